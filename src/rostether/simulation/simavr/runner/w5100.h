/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The interface between the W5100's registers and its network. */
#ifndef W5100_H
#define W5100_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define W5100_SOCKETS 4
#define W5100_MEMORY 2048

struct w5100_place {
    uint8_t ip[4];
    uint16_t port;
};

/* w5100.c: a datagram arrived for a socket; false if the socket does not receive it, or has no room. */
bool w5100_deliver(int s, const struct w5100_place *from, const uint8_t *bytes, size_t count);

/* w5100_network.c: returns NULL, or the error; `group` is NULL for a socket without a group. */
const char *network_udp_open(int s, uint16_t port, const uint8_t *group);
void network_udp_close(int s);
/* Sends a datagram; returns false if no machine has the address. */
bool network_udp_send(int s, const uint8_t *bytes, size_t count, const struct w5100_place *to);

#endif
