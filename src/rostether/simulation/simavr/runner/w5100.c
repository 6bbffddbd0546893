/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A W5100 on SPI, selected by D10 as on Arduino's shields: registers, and four sockets for UDP with 2 KiB each way. Its
 * network is w5100_network.c.
 *
 * As on the chip, a multicast socket keeps the group's address from its opening, and sends only to this address.
 * Not modeled: TCP, IP and MAC raw sockets, PPPoE, interrupts, other sizes of memory.
 */
#include <stdio.h>
#include <string.h>

#include "board.h"
#include "w5100.h"

#define SELECT "D10"
#define READ 0x0f
#define WRITE 0xf0

#define MODE 0x0000
#define RESET 0x80
#define OWN_IP 0x000f
#define RETRY_TIME 0x0017
#define RETRY_COUNT 0x0019
#define MEMORY_SIZES 0x001a
#define COMMON_END 0x0030
#define SOCKETS 0x0400
#define SOCKETS_END 0x0800
#define SENT 0x4000
#define RECEIVED 0x6000
#define SPACE 0x8000

/* The registers of a socket. */
#define SOCKET_BYTES 0x100
#define COMMAND 0x01
#define FLAGS 0x02
#define STATE 0x03
#define PORT 0x04
#define PEER_IP 0x0c
#define PEER_PORT 0x10
#define TIME_TO_LIVE 0x16
#define SEND_FREE 0x20
#define SEND_READ 0x22
#define SEND_WRITE 0x24
#define RECEIVED_SIZE 0x26
#define RECEIVED_READ 0x28

#define OPEN 0x01
#define CLOSE 0x10
#define SEND 0x20
#define SEND_MAC 0x21
#define RECEIVE 0x40
#define UDP 0x02
#define PROTOCOL 0x0f
#define MULTICAST 0x80
#define STATE_UDP 0x22
#define FLAG_RECEIVED 0x04
#define FLAG_TIMEOUT 0x08
#define FLAG_SENT 0x10

static uint8_t memory[SPACE];
static struct {
    struct w5100_place group; /* from when the socket was opened; port 0 without a group */
    uint16_t freed;           /* the end of the bytes that the program has read */
    uint16_t filled;          /* the end of the received bytes */
    uint16_t sent;
    unsigned long heard; /* datagrams since the socket was opened */
    bool is_stalled;     /* and reported as stalled */
    uint64_t gives_up;   /* the cycle at which an address request times out; 0 without a request */
} sockets[W5100_SOCKETS];
static unsigned long stall_after;
static struct pin *select_pin;
static uint8_t frame[3];
static unsigned frame_count;

void w5100_set_stall(unsigned long after) { stall_after = after; }

static uint8_t *of_socket(int s, int place) { return memory + SOCKETS + s * SOCKET_BYTES + place; }

static uint16_t get16(const uint8_t *bytes) { return (uint16_t)(bytes[0] << 8 | bytes[1]); }

static void put16(uint8_t *bytes, unsigned value) {
    bytes[0] = (uint8_t)(value >> 8);
    bytes[1] = (uint8_t)value;
}

static void report(int s, const char *state) {
    char place[32];
    const uint8_t *ip = sockets[s].group.ip;
    if (sockets[s].group.port)
        snprintf(place, sizeof place, "%u.%u.%u.%u:%u", ip[0], ip[1], ip[2], ip[3], get16(of_socket(s, PORT)));
    else
        snprintf(place, sizeof place, "%u", get16(of_socket(s, PORT)));
    event_begin("w5100");
    event_int("socket", s);
    event_text("state", state);
    event_text("at", place);
    event_end();
}

static void close_socket(int s) {
    if (*of_socket(s, STATE)) {
        network_udp_close(s);
        report(s, "closed");
    }
    *of_socket(s, STATE) = 0;
    memset(&sockets[s], 0, sizeof sockets[s]);
}

static void open_socket(int s) {
    uint8_t mode = *of_socket(s, 0);
    close_socket(s);
    if ((mode & PROTOCOL) != UDP) return;
    if (mode & MULTICAST) {
        memcpy(sockets[s].group.ip, of_socket(s, PEER_IP), 4);
        sockets[s].group.port = get16(of_socket(s, PEER_PORT));
    }
    const char *error = network_udp_open(s, get16(of_socket(s, PORT)), mode & MULTICAST ? sockets[s].group.ip : NULL);
    memset(of_socket(s, SEND_READ), 0, 4);
    memset(of_socket(s, RECEIVED_READ), 0, 2);
    *of_socket(s, FLAGS) = 0;
    *of_socket(s, STATE) = STATE_UDP;
    report(s, error ? error : "opened");
}

static void send_datagram(int s) {
    uint8_t bytes[W5100_MEMORY];
    struct w5100_place to = sockets[s].group;
    uint16_t from = sockets[s].sent, count = (uint16_t)(get16(of_socket(s, SEND_WRITE)) - from);
    if (*of_socket(s, STATE) != STATE_UDP || count > W5100_MEMORY) return;
    for (uint16_t i = 0; i < count; i++) bytes[i] = memory[SENT + s * W5100_MEMORY + (from + i) % W5100_MEMORY];
    if (!to.port) {
        memcpy(to.ip, of_socket(s, PEER_IP), 4);
        to.port = get16(of_socket(s, PEER_PORT));
    }
    sockets[s].sent = (uint16_t)(from + count);
    put16(of_socket(s, SEND_READ), sockets[s].sent);
    if (network_udp_send(s, bytes, count, &to)) {
        *of_socket(s, FLAGS) |= FLAG_SENT;
        return;
    }
    /* The register has units of 100 µs; the first attempt and each retry take that long. */
    sockets[s].gives_up =
        board.avr->cycle + get16(memory + RETRY_TIME) * (memory[RETRY_COUNT] + 1ull) * 100 * CYCLES_PER_US;
}

bool w5100_deliver(int s, const struct w5100_place *from, const uint8_t *bytes, size_t count) {
    uint16_t used = (uint16_t)(sockets[s].filled - sockets[s].freed);
    uint8_t header[8] = {from->ip[0], from->ip[1], from->ip[2], from->ip[3]};
    if (*of_socket(s, STATE) != STATE_UDP) return false;
    if (sockets[s].group.port && stall_after && sockets[s].heard >= stall_after) {
        if (!sockets[s].is_stalled) report(s, "stalled");
        sockets[s].is_stalled = true;
        return false;
    }
    sockets[s].heard++;
    if (used + sizeof header + count > W5100_MEMORY) return false;
    put16(header + 4, from->port);
    put16(header + 6, (unsigned)count);
    for (size_t i = 0; i < sizeof header + count; i++, sockets[s].filled++)
        memory[RECEIVED + s * W5100_MEMORY + sockets[s].filled % W5100_MEMORY] =
            i < sizeof header ? header[i] : bytes[i - sizeof header];
    *of_socket(s, FLAGS) |= FLAG_RECEIVED;
    return true;
}

static void reset(void) {
    for (int s = 0; s < W5100_SOCKETS; s++) close_socket(s);
    memset(memory, 0, sizeof memory);
    put16(memory + RETRY_TIME, 2000);
    memory[RETRY_COUNT] = 8;
    memory[MEMORY_SIZES] = memory[MEMORY_SIZES + 1] = 0x55;
    for (int s = 0; s < W5100_SOCKETS; s++) *of_socket(s, TIME_TO_LIVE) = 128;
}

static void perform(int s, uint8_t command) {
    if (command == OPEN) open_socket(s);
    if (command == CLOSE) close_socket(s);
    if (command == SEND || command == SEND_MAC) send_datagram(s);
    if (command == RECEIVE) sockets[s].freed = get16(of_socket(s, RECEIVED_READ));
}

static uint8_t read_at(unsigned address) {
    if (address >= SOCKETS && address < SOCKETS_END) {
        int s = (int)(address - SOCKETS) / SOCKET_BYTES;
        put16(of_socket(s, RECEIVED_SIZE), (uint16_t)(sockets[s].filled - sockets[s].freed));
        put16(of_socket(s, SEND_FREE),
              (unsigned)(W5100_MEMORY - (uint16_t)(get16(of_socket(s, SEND_WRITE)) - sockets[s].sent)));
        if (sockets[s].gives_up && board.avr->cycle >= sockets[s].gives_up) {
            sockets[s].gives_up = 0;
            *of_socket(s, FLAGS) |= FLAG_TIMEOUT;
        }
    }
    return address < SPACE ? memory[address] : 0;
}

static void write_at(unsigned address, uint8_t byte) {
    bool of_sockets = address >= SOCKETS && address < SOCKETS_END;
    int s = (int)(address - SOCKETS) / SOCKET_BYTES, place = (int)(address - SOCKETS) % SOCKET_BYTES;
    if (address == MODE && byte & RESET) {
        reset();
    } else if (of_sockets && place == COMMAND) {
        /* The register stays 0, because the chip has accepted the command immediately. */
        perform(s, byte);
    } else if (of_sockets && place == FLAGS) {
        memory[address] &= (uint8_t)~byte;
    } else if (of_sockets && (place == STATE || (place >= SEND_FREE && place < SEND_WRITE) ||
                              (place >= RECEIVED_SIZE && place < RECEIVED_READ))) {
        /* Read only. */
    } else if (of_sockets || address < COMMON_END || (address >= SENT && address < RECEIVED)) {
        memory[address] = byte;
    }
}

static void on_select(struct pin *pin, bool level) {
    (void)pin, (void)level;
    frame_count = 0;
}

bool w5100_is_selected(void) { return pin_is_output(select_pin) && !pin_level(select_pin); }

/* The bytes of an access: READ or WRITE, address high, address low, data. The chip answers 0, 1, 2 to the first three. */
uint8_t w5100_exchange(uint8_t byte) {
    if (frame_count < sizeof frame) {
        frame[frame_count] = byte;
        return (uint8_t)frame_count++;
    }
    unsigned address = get16(frame + 1);
    frame_count = 0;
    if (*frame == WRITE) write_at(address, byte);
    return *frame == READ ? read_at(address) : (uint8_t)sizeof frame;
}

/* The board's reset button also resets the shield. */
void w5100_reset(void) {
    reset();
    frame_count = 0;
    pin_listen(select_pin, on_select);
}

void w5100_start(void) { select_pin = pin_named(SELECT); }
