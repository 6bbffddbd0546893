/* SPDX-License-Identifier: GPL-3.0-or-later */
/* rostether-simavr: a simulated Arduino board that runs a real program. Started by rostether; see board.h. */
#include <fcntl.h>
#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "board.h"
#include "instructions.h"

/* The addresses that a 16-bit pointer with a displacement can have: the simulator writes there without a check. */
#define DATA_SPACE_BYTES 0x10200

struct board board = {.running = true, .stop_at = NEVER};

struct settings {
    const char *kind, *link, *firmware;
    char uart;
};

static int fail(const char *text) {
    event_begin("failed");
    event_text("text", text);
    event_end();
    board.quitting = true;
    events_flush();
    return 1;
}

/* The simulator also prints to stdout; events have a separate descriptor. */
static void keep_output_for_events(void) {
    int events = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3), nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    events_open(events);
    if (nowhere >= 0) dup2(nowhere, STDOUT_FILENO);
}

static void end_with_parent(void) {
    pid_t parent = getppid();
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);
    /* Ctrl-C and a service manager signal all processes of a group; rostether ends this one. */
    signal(SIGINT, SIG_IGN);
    signal(SIGTERM, SIG_IGN);
    signal(SIGPIPE, SIG_IGN);
}

static bool read_settings(int count, char **arguments, struct settings *settings) {
    static const struct option options[] = {
        {"board", required_argument, NULL, 'b'}, {"link", required_argument, NULL, 'l'},
        {"uart", required_argument, NULL, 'u'},  {"seed", required_argument, NULL, 's'},
        {"fast", no_argument, NULL, 'f'},        {"paused", no_argument, NULL, 'p'},
        {NULL, 0, NULL, 0},
    };
    int option;
    while ((option = getopt_long(count, arguments, "", options, NULL)) != -1) {
        if (option == 'b') settings->kind = optarg;
        else if (option == 'l') settings->link = optarg;
        else if (option == 'u') settings->uart = *optarg;
        else if (option == 's') power_seed(strtoull(optarg, NULL, 0));
        else if (option == 'f') board.fast = true;
        else if (option == 'p') board.running = false;
        else return false;
    }
    settings->firmware = optind < count ? arguments[optind] : NULL;
    return settings->firmware != NULL;
}

static bool open_link(const char *link) {
    if (strcmp(link, "none") == 0) return true;
    if (strcmp(link, "pty") == 0) return link_open_pty();
    return strncmp(link, "tcp:", 4) == 0 && link_open_tcp((unsigned)atoi(link + 4));
}

static bool make_chip(void) {
    avr_t *avr = board.avr = avr_make_mcu_by_name(board.kind->mcu);
    if (!avr) return false;
    avr_init(avr);
    avr->frequency = CLOCK_HZ;
    avr->vcc = avr->avcc = avr->aref = 5000;
    uint8_t *data = calloc(1, DATA_SPACE_BYTES);
    if (!data) return false;
    memcpy(data, avr->data, (size_t)avr->ramend + 1);
    free(avr->data);
    avr->data = data;
    return true;
}

static void report_ready(char uart) {
    event_begin("ready");
    event_text("board", board.kind->name);
    event_text("mcu", board.kind->mcu);
    event_text("link", link_address());
    event_int("uart", uart - '0');
    event_int("program_bytes", board.avr->codeend);
    if (strcmp(board.kind->name, "leonardo") == 0 && uart == '1')
        event_text("note", "its USB is not simulated: the link is Serial1, the pins D0 and D1");
    event_end();
}

int main(int count, char **arguments) {
    char error[512];
    struct settings settings = {"uno", "pty", NULL, 0};
    keep_output_for_events();
    end_with_parent();
    if (!read_settings(count, arguments, &settings))
        return fail("usage: rostether-simavr [--board B] [--link pty|tcp:PORT|none] [--uart N] [--seed N] [--fast] "
                    "[--paused] FIRMWARE [COMMAND]...");
    board.kind = board_kind_named(settings.kind);
    if (!board.kind) return fail("boards are uno, nano, mega and leonardo");
    canaries_start();
    if (!make_chip()) return fail("this libsimavr does not know the board's chip");
    if (!firmware_load(settings.firmware, error, sizeof error)) return fail(error);
    char uart = settings.uart ? settings.uart : board.kind->link_uart;
    if (!uart_start(uart)) return fail("the board has no such UART; choose another --uart");
    if (!open_link(settings.link)) return fail("the link cannot be opened; choose pty, none, or tcp: with another port");
    instructions_decode();
    timers_start();
    adc_start();
    twi_start();
    network_start();
    spi_start();
    w5100_start();
    markers_start();
    report_ready(uart);
    while (++optind < count) command_run(arguments[optind]);
    power_on("power");
    return pacing_loop();
}
