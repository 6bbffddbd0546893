/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The host's end of the UART: a pseudo-terminal, a TCP port on loopback, or only events and the command `send`.
 * As on a real cable, bytes are lost if no host has opened it. A host that sends faster than the line must wait.
 */
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include "board.h"

/* More than a second at 115200 baud; a host that pauses longer also loses bytes on hardware. */
#define OUTPUT_ROOM 16384
#define INJECTED_ROOM 65536
#define WATCHED_ROOM 1024

static enum { NO_LINK, PTY, TCP } kind;
static char address[64];
static int terminal = -1, terminal_slave = -1, terminal_watch = -1;
static int listener = -1, connection = -1;
static int openers;
static bool autoreset, powered, watching;
static struct {
    uint8_t byte;
    cycles_t due;
} output[OUTPUT_ROOM];
static size_t output_first, output_count;
static cycles_t last_due;
static unsigned long lost;
static uint8_t injected[INJECTED_ROOM], watched[WATCHED_ROOM];
static size_t injected_first, injected_count, watched_count;

const char *link_address(void) { return address; }

bool link_open_pty(void) {
    struct termios raw;
    terminal = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (terminal < 0 || grantpt(terminal) || unlockpt(terminal)) return false;
    if (ptsname_r(terminal, address, sizeof address)) return false;
    /* This one stays open: without it, the terminal would lose its raw mode, and reading it would fail. */
    terminal_slave = open(address, O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (terminal_slave < 0 || tcgetattr(terminal_slave, &raw)) return false;
    cfmakeraw(&raw);
    tcsetattr(terminal_slave, TCSANOW, &raw);
    terminal_watch = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    if (terminal_watch >= 0 && inotify_add_watch(terminal_watch, address, IN_OPEN | IN_CLOSE) < 0) {
        close(terminal_watch);
        terminal_watch = -1;
    }
    kind = PTY;
    return true;
}

bool link_open_tcp(unsigned port) {
    struct sockaddr_in place = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port)};
    socklen_t size = sizeof place;
    int yes = 1;
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    listener = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (listener < 0 || bind(listener, (struct sockaddr *)&place, size) || listen(listener, 1)) return false;
    getsockname(listener, (struct sockaddr *)&place, &size);
    snprintf(address, sizeof address, "tcp://127.0.0.1:%u?connect=yes", ntohs(place.sin_port));
    kind = TCP;
    return true;
}

static bool is_listening(void) {
    return kind == TCP ? connection >= 0 : kind == PTY && (terminal_watch < 0 || openers > 0);
}

/* The next host must not get the unread bytes of the previous one. */
static void forget_output(void) {
    output_count = 0;
    if (kind == PTY) tcflush(terminal_slave, TCIFLUSH);
}

static void on_host_opened(void) {
    forget_output();
    if (autoreset) power_reset("host");
}

static void notice_openers(void) {
    char notes[4096] __attribute__((aligned(8)));
    ssize_t count;
    while (terminal_watch >= 0 && (count = read(terminal_watch, notes, sizeof notes)) > 0)
        for (char *at = notes; at < notes + count;) {
            const struct inotify_event *note = (const struct inotify_event *)at;
            if (note->mask & IN_OPEN && openers++ == 0) on_host_opened();
            if (note->mask & IN_CLOSE && openers > 0 && --openers == 0) forget_output();
            at += sizeof *note + note->len;
        }
}

static void notice_connection(void) {
    if (kind != TCP || connection >= 0) return;
    int yes = 1;
    connection = accept4(listener, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (connection < 0) return;
    setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    on_host_opened();
}

static void hang_up(void) {
    if (kind != TCP || connection < 0) return;
    close(connection);
    connection = -1;
}

static int descriptor(void) { return kind == TCP ? connection : terminal; }

static void to_board(uint8_t byte) {
    struct faulty_byte arrived = faults_apply(TO_BOARD, byte);
    if (!arrived.lost) uart_receive(arrived.byte, arrived.delayed);
}

void link_receive(void) {
    uint8_t bytes[512];
    notice_openers();
    notice_connection();
    for (; injected_count && uart_room(); injected_count--) {
        if (powered) to_board(injected[injected_first]);
        injected_first = (injected_first + 1) % INJECTED_ROOM;
    }
    if (kind == NO_LINK || descriptor() < 0) return;
    size_t room = uart_room();
    if (room == 0) return;
    ssize_t count = read(descriptor(), bytes, room < sizeof bytes ? room : sizeof bytes);
    if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) hang_up();
    for (ssize_t i = 0; powered && i < count; i++) to_board(bytes[i]);
}

static void report_watched(void) {
    if (!watched_count) return;
    event_begin("serial");
    event_hex("data", watched, watched_count);
    event_end_droppable();
    watched_count = 0;
}

void link_send(uint8_t byte) {
    struct faulty_byte sent = faults_apply(FROM_BOARD, byte);
    if (sent.lost) return;
    if (watching) {
        watched[watched_count++] = sent.byte;
        if (watched_count == WATCHED_ROOM) report_watched();
    }
    if (!is_listening()) return;
    cycles_t due = board.avr->cycle + (sent.delayed ? faults_delay_cycles(FROM_BOARD) : 0);
    if (due < last_due) due = last_due;
    last_due = due;
    if (output_count == OUTPUT_ROOM) link_flush();
    if (output_count == OUTPUT_ROOM) {
        lost++;
        return;
    }
    size_t last = (output_first + output_count++) % OUTPUT_ROOM;
    output[last].byte = sent.byte;
    output[last].due = due;
}

/* Writes the waiting bytes; false if the host accepts no more now. */
static bool write_due(void) {
    uint8_t bytes[1024];
    size_t count = 0;
    while (count < sizeof bytes && count < output_count) {
        size_t at = (output_first + count) % OUTPUT_ROOM;
        if (output[at].due > board.avr->cycle) break;
        bytes[count++] = output[at].byte;
    }
    if (count == 0) return false;
    ssize_t written = kind == TCP ? send(connection, bytes, count, MSG_NOSIGNAL) : write(terminal, bytes, count);
    if (written < 0 && errno != EAGAIN && errno != EINTR) hang_up();
    if (written <= 0) return false;
    output_first = (output_first + (size_t)written) % OUTPUT_ROOM;
    output_count -= (size_t)written;
    return true;
}

void link_flush(void) {
    report_watched();
    if (!is_listening()) {
        output_count = 0;
        return;
    }
    while (output_count && write_due()) continue;
    /* Without real time, the board waits for its host instead of losing bytes. */
    while (board.fast && output_count > OUTPUT_ROOM / 2 && is_listening() && !board.quitting) {
        struct pollfd wanted[2] = {{.fd = descriptor(), .events = POLLOUT}, {.fd = STDIN_FILENO, .events = POLLIN}};
        poll(wanted, 2, 100);
        if (wanted[1].revents) commands_read();
        notice_openers();
        if (!write_due() && output[output_first].due > board.avr->cycle) break;
    }
    if (lost) {
        event_begin("lost_serial");
        event_int("bytes", (long long)lost);
        event_end();
        lost = 0;
    }
}

/* Queues bytes for the board, given in hexadecimal; they arrive at line speed, like those of the host. */
const char *link_inject(const char *hex) {
    size_t count = strlen(hex) / 2;
    if (strlen(hex) % 2 || strspn(hex, "0123456789abcdefABCDEF") != 2 * count)
        return "write the bytes in hexadecimal, as in send 48656c6c6f";
    if (count > INJECTED_ROOM - injected_count) return "too many bytes are waiting; send them in smaller parts";
    for (size_t i = 0; i < count; i++) {
        unsigned byte;
        sscanf(hex + 2 * i, "%2x", &byte);
        injected[(injected_first + injected_count++) % INJECTED_ROOM] = (uint8_t)byte;
    }
    return NULL;
}

void link_watch(bool on) { watching = on; }

void link_power(bool on) { powered = on; }

void link_autoreset(bool on) { autoreset = on; }

void link_close(void) {
    int descriptors[] = {terminal, terminal_slave, terminal_watch, listener, connection};
    for (size_t i = 0; i < sizeof descriptors / sizeof *descriptors; i++)
        if (descriptors[i] >= 0) close(descriptors[i]);
    kind = NO_LINK;
}
