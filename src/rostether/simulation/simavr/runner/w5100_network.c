/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The W5100's network: UDP sockets on loopback of this machine. The board has the address 127.0.0.2, or another loopback
 * address, regardless of the sketch's settings; DHCP offers it.
 */
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "board.h"
#include "w5100.h"

#define LOOPBACK 127
#define DHCP_SERVER 67
#define DHCP_CLIENT 68
#define DHCP_OPTIONS 240
#define DHCP_KIND 53
#define DISCOVER 1
#define REQUEST 3
#define OFFER 2
#define ACKNOWLEDGE 5
/* The maximum number of datagrams in a slice; more wait for the next slice. */
#define BURST 32

static uint8_t own_ip[4] = {LOOPBACK, 0, 0, 2};
static const uint8_t server_ip[4] = {LOOPBACK, 0, 0, 1};
static struct {
    int own, group; /* the sockets of the board's address and of the group; -1 if closed */
    uint16_t port;
} sockets[W5100_SOCKETS] = {{-1, -1, 0}, {-1, -1, 0}, {-1, -1, 0}, {-1, -1, 0}};

static struct sockaddr_in address_of(const uint8_t *ip, uint16_t port) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons(port)};
    memcpy(&address.sin_addr, ip, 4);
    return address;
}

static int open_at(const uint8_t *ip, uint16_t port) {
    struct sockaddr_in address = address_of(ip, port);
    int yes = 1, fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    struct in_addr interface;
    memcpy(&interface, own_ip, 4);
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof interface);
    if (bind(fd, (struct sockaddr *)&address, sizeof address) == 0) return fd;
    close(fd);
    return -1;
}

const char *network_udp_open(int s, uint16_t port, const uint8_t *group) {
    sockets[s].port = port;
    /* DHCP needs no socket: `serve_dhcp` answers, because the real port belongs to this machine's own client. */
    if (port == DHCP_CLIENT) return NULL;
    sockets[s].own = open_at(own_ip, port);
    if (sockets[s].own < 0) return "port in use";
    if (!group) return NULL;
    struct ip_mreq membership;
    memcpy(&membership.imr_multiaddr, group, 4);
    memcpy(&membership.imr_interface, own_ip, 4);
    sockets[s].group = open_at(group, port);
    if (sockets[s].group < 0 ||
        setsockopt(sockets[s].group, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) < 0)
        return "no such group";
    return NULL;
}

void network_udp_close(int s) {
    if (sockets[s].own >= 0) close(sockets[s].own);
    if (sockets[s].group >= 0) close(sockets[s].group);
    sockets[s].own = sockets[s].group = -1;
    sockets[s].port = 0;
}

static size_t put_option(uint8_t *bytes, uint8_t option, const void *value, uint8_t count) {
    bytes[0] = option;
    bytes[1] = count;
    memcpy(bytes + 2, value, count);
    return count + 2u;
}

/* Answers a DISCOVER with an OFFER, and a REQUEST with an ACKNOWLEDGE (RFC 2131). */
static void serve_dhcp(int s, const uint8_t *request, size_t count) {
    static const uint8_t mask[4] = {255, 0, 0, 0}, lease[4] = {0, 1, 0x51, 0x80};
    uint8_t answer[DHCP_OPTIONS + 48] = {2}, kind = 0;
    if (count < DHCP_OPTIONS || sockets[s].port != DHCP_CLIENT) return;
    for (size_t i = DHCP_OPTIONS; i + 2 < count && request[i] != 255; i += request[i] ? request[i + 1] + 2u : 1u)
        if (request[i] == DHCP_KIND) kind = request[i + 2] == DISCOVER ? OFFER : request[i + 2] == REQUEST ? ACKNOWLEDGE : 0;
    if (!kind) return;
    memcpy(answer + 1, request + 1, 43);
    memcpy(answer + 16, own_ip, 4);
    memcpy(answer + 20, server_ip, 4);
    memcpy(answer + 236, request + 236, 4);
    size_t end = DHCP_OPTIONS;
    end += put_option(answer + end, DHCP_KIND, &kind, 1);
    end += put_option(answer + end, 54, server_ip, 4);
    end += put_option(answer + end, 51, lease, 4);
    end += put_option(answer + end, 1, mask, 4);
    end += put_option(answer + end, 3, server_ip, 4);
    end += put_option(answer + end, 6, server_ip, 4);
    answer[end++] = 255;
    struct w5100_place from = {.port = DHCP_SERVER};
    memcpy(from.ip, server_ip, 4);
    w5100_deliver(s, &from, answer, end);
}

/* Only addresses of this machine can be bound. */
static bool is_this_machine(const uint8_t *ip) {
    if (*ip == LOOPBACK) return true;
    int fd = open_at(ip, 0);
    if (fd < 0) return false;
    close(fd);
    return true;
}

bool network_udp_send(int s, const uint8_t *bytes, size_t count, const struct w5100_place *to) {
    bool is_broadcast = to->ip[0] == 255, is_group = to->ip[0] >> 4 == 14;
    if (is_broadcast) {
        if (to->port == DHCP_SERVER) serve_dhcp(s, bytes, count);
        return true;
    }
    if (!is_group && !is_this_machine(to->ip)) return false;
    struct sockaddr_in address = address_of(to->ip, to->port);
    if (sockets[s].own >= 0) sendto(sockets[s].own, bytes, count, 0, (struct sockaddr *)&address, sizeof address);
    return true;
}

static void receive(int s, int fd) {
    uint8_t bytes[W5100_MEMORY];
    struct sockaddr_in source;
    for (int i = 0; fd >= 0 && i < BURST; i++) {
        socklen_t size = sizeof source;
        ssize_t count = recvfrom(fd, bytes, sizeof bytes, MSG_TRUNC, (struct sockaddr *)&source, &size);
        if (count < 0) return;
        struct w5100_place from = {.port = ntohs(source.sin_port)};
        memcpy(from.ip, &source.sin_addr, 4);
        if ((size_t)count <= sizeof bytes) w5100_deliver(s, &from, bytes, (size_t)count);
    }
}

/* Receives datagrams, between slices. */
void w5100_move(void) {
    for (int s = 0; s < W5100_SOCKETS; s++) {
        receive(s, sockets[s].group);
        receive(s, sockets[s].own);
    }
}

static const char *set_one(char *part) {
    struct in_addr address;
    char *value = strchr(part, '='), *rest;
    if (!value) return "write the settings as in w5100 address=127.0.0.2,stall_after=500";
    *value++ = 0;
    if (strcmp(part, "address") == 0 && inet_pton(AF_INET, value, &address) == 1 && *(uint8_t *)&address == LOOPBACK) {
        memcpy(own_ip, &address, 4);
        return NULL;
    }
    unsigned long after = strtoul(value, &rest, 10);
    if (strcmp(part, "stall_after") != 0 || *value < '0' || *value > '9' || *rest)
        return "write an address from 127.0.0.1 to 127.255.255.254, and stall_after as a number of datagrams (0: never)";
    w5100_set_stall(after);
    return NULL;
}

/* Reads address=127.0.0.2,stall_after=500. */
const char *w5100_set(char *settings) {
    char *rest = NULL;
    for (char *part = strtok_r(settings, ",", &rest); part; part = strtok_r(NULL, ",", &rest)) {
        const char *error = set_one(part);
        if (error) return error;
    }
    return NULL;
}
