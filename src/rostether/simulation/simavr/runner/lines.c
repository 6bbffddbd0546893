/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Commands from stdin and from the command line. The answer to an invalid one is an event "error". If a line begins with
 * #NUMBER, its answer is "done" or "error" with that number. The end of stdin ends the program.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "board.h"

#define LONGEST_LINE (64 * 1024)

void command_run(char *line) {
    char *rest = line;
    long long number = *line == '#' ? strtoll(line + 1, &rest, 10) : -1;
    line = rest;
    char shown[80];
    snprintf(shown, sizeof shown, "%s", line + strspn(line, " "));
    const char *error = command_perform(line);
    if (!error && number < 0) return;
    event_begin(error ? "error" : "done");
    if (number >= 0) event_int("id", number);
    if (error) {
        event_text("line", shown);
        event_text("text", error);
    }
    event_end();
}

void commands_read(void) {
    static char line[LONGEST_LINE];
    static size_t length;
    static bool too_long;
    char bytes[4096];
    ssize_t count = read(STDIN_FILENO, bytes, sizeof bytes);
    if (count < 0 && errno == EINTR) return;
    if (count <= 0) {
        board.quitting = true;
        return;
    }
    for (ssize_t i = 0; i < count; i++) {
        if (bytes[i] != '\n') {
            too_long |= length == LONGEST_LINE - 1;
            if (!too_long) line[length++] = bytes[i];
            continue;
        }
        line[length] = 0;
        if (too_long) line[64] = 0;
        command_run(line);
        length = 0;
        too_long = false;
    }
}
