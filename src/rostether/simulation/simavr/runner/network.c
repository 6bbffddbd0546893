/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The simulated network chip of the Ethernet library for simulated boards:
 *
 *     GPIOR1  while idle, write the IPv4 address, then the port, low byte first; while connected, write or
 *             read a byte
 *     GPIOR0  write 1 to connect, 2 to stop; read bit 0: connected, bit 1: a byte waits, bit 2: room to send
 *
 * All connections go to the host of the command `network`, regardless of the sketch's address; without it, they fail.
 */
#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "board.h"

#define GPIOR0 0x3e
#define GPIOR1 0x4a
#define CONNECT 1
#define STOP 2
#define CONNECTED 0x01
#define WAITING 0x02
#define ROOM 0x04
/* The memory of a W5100's socket in each direction. */
#define BUFFER 2048
#define CONNECT_MS 3000
#define ADDRESS_BYTES 6

static char host[256], service[8];
static int connection = -1;
static bool connecting, ended, asked_is_used;
static uint8_t incoming[BUFFER], outgoing[BUFFER], asked[ADDRESS_BYTES];
static size_t incoming_first, incoming_count, outgoing_count, asked_count;

const char *network_connects_to(const char *host_and_port) {
    const char *colon = strrchr(host_and_port, ':');
    size_t length = colon ? (size_t)(colon - host_and_port) : 0;
    if (!length || length >= sizeof host || strlen(colon + 1) >= sizeof service || !colon[1])
        return "write the address as HOST:PORT";
    memcpy(host, host_and_port, length);
    host[length] = 0;
    strcpy(service, colon + 1);
    return NULL;
}

static void report(const char *state) {
    char place[32] = "";
    if (asked_count == ADDRESS_BYTES)
        snprintf(place, sizeof place, "%u.%u.%u.%u:%u", asked[0], asked[1], asked[2], asked[3],
                 asked[4] | asked[5] << 8);
    event_begin("network");
    event_text("state", state);
    event_text("asked", place);
    event_end();
}

static void hang_up(void) {
    if (connection >= 0) close(connection);
    connection = -1;
    connecting = ended = false;
    incoming_count = outgoing_count = 0;
}

static void finish_connecting(int timeout_ms) {
    struct pollfd wanted = {.fd = connection, .events = POLLOUT};
    int error = 0;
    socklen_t size = sizeof error;
    if (poll(&wanted, 1, timeout_ms) <= 0) return;
    connecting = false;
    getsockopt(connection, SOL_SOCKET, SO_ERROR, &error, &size);
    if (error) hang_up();
    report(error ? "refused" : "connected");
}

static void open_connection(void) {
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM}, *found = NULL;
    int yes = 1;
    hang_up();
    if (!host[0] || getaddrinfo(host, service, &hints, &found)) {
        report("unreachable");
        return;
    }
    connection = socket(found->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    bool begun = connect(connection, found->ai_addr, found->ai_addrlen) == 0 || errno == EINPROGRESS;
    freeaddrinfo(found);
    if (!begun) {
        hang_up();
        report("refused");
        return;
    }
    connecting = true;
    /* Without real time, the board may wait for the network. */
    finish_connecting(board.fast ? CONNECT_MS : 0);
}

static void write_command(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param) {
    (void)avr, (void)address, (void)param;
    if (value == CONNECT) open_connection();
    if (value == STOP && connection >= 0) {
        network_move();
        hang_up();
        report("stopped");
    }
    asked_is_used = true;
}

static uint8_t read_status(avr_t *avr, avr_io_addr_t address, void *param) {
    (void)param;
    uint8_t status = 0;
    if (connection >= 0 && !connecting && !(ended && !incoming_count)) status |= CONNECTED;
    if (incoming_count) status |= WAITING;
    if (status & CONNECTED && outgoing_count < BUFFER) status |= ROOM;
    return avr->data[address] = status;
}

static void write_data(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param) {
    (void)avr, (void)address, (void)param;
    if (connection < 0) {
        if (asked_is_used || asked_count == ADDRESS_BYTES) asked_count = 0;
        asked_is_used = false;
        asked[asked_count++] = value;
    } else if (outgoing_count < BUFFER) {
        outgoing[outgoing_count++] = value;
    }
}

static uint8_t read_data(avr_t *avr, avr_io_addr_t address, void *param) {
    (void)param;
    uint8_t byte = 0;
    if (incoming_count) {
        byte = incoming[incoming_first];
        incoming_first = (incoming_first + 1) % BUFFER;
        incoming_count--;
    }
    return avr->data[address] = byte;
}

static void receive(void) {
    while (incoming_count < BUFFER && !ended) {
        size_t last = (incoming_first + incoming_count) % BUFFER;
        size_t room = last < incoming_first ? incoming_first - last : BUFFER - last;
        if (room > BUFFER - incoming_count) room = BUFFER - incoming_count;
        ssize_t count = recv(connection, incoming + last, room, 0);
        if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
        if (count <= 0) {
            ended = true;
            report("closed");
            return;
        }
        incoming_count += (size_t)count;
    }
}

/* Exchanges bytes with the network, between slices. */
void network_move(void) {
    if (connection < 0) return;
    if (connecting) finish_connecting(0);
    if (connection < 0 || connecting) return;
    receive();
    if (!outgoing_count) return;
    ssize_t count = send(connection, outgoing, outgoing_count, MSG_NOSIGNAL);
    if (count <= 0) return;
    outgoing_count -= (size_t)count;
    memmove(outgoing, outgoing + count, outgoing_count);
}

void network_reset(void) {
    hang_up();
    asked_count = 0;
}

void network_start(void) {
    avr_register_io_write(board.avr, GPIOR0, write_command, NULL);
    avr_register_io_read(board.avr, GPIOR0, read_status, NULL);
    avr_register_io_write(board.avr, GPIOR1, write_data, NULL);
    avr_register_io_read(board.avr, GPIOR1, read_data, NULL);
}
