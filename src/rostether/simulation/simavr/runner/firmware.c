/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Loads programs: ELF files with symbols, and Intel HEX files. Programs for another chip are refused. */
#include <fcntl.h>
#include <gelf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <avr_eeprom.h>

#include "board.h"

#define DATA_SPACE 0x800000u
#define EEPROM_SPACE 0x810000u
#define FUSE_SPACE 0x820000u
#define ARCHITECTURE_MASK 0x7fu

static struct symbol *symbols;
static size_t symbol_count;
static uint32_t data_end;

const struct symbol *firmware_symbol(const char *name) {
    for (size_t i = 0; i < symbol_count; i++)
        if (strcmp(symbols[i].name, name) == 0) return &symbols[i];
    return NULL;
}

uint32_t firmware_heap_start(void) { return data_end; }

/* Without malloc, the heap is empty. */
uint32_t firmware_heap_end(void) {
    const uint8_t *place = board.avr->data + board.heap_end_place;
    uint32_t top = board.heap_end_place ? place[0] | place[1] << 8 : 0;
    return top > data_end && top <= board.avr->ramend ? top : data_end;
}

static bool to_flash(uint32_t address, const uint8_t *bytes, size_t count) {
    avr_t *avr = board.avr;
    if (address > avr->flashend || count > avr->flashend + 1 - address) return false;
    memcpy(avr->flash + address, bytes, count);
    return true;
}

static bool to_eeprom(uint32_t offset, uint8_t *bytes, size_t count) {
    if (offset > board.avr->e2end || count > board.avr->e2end + 1 - offset) return false;
    avr_eeprom_desc_t content = {.ee = bytes, .offset = (uint16_t)offset, .size = (uint32_t)count};
    return avr_ioctl(board.avr, AVR_IOCTL_EEPROM_SET, &content) >= 0;
}

static void read_symbols(Elf *elf, Elf_Scn *section, const GElf_Shdr *header) {
    Elf_Data *data = elf_getdata(section, NULL);
    size_t count = header->sh_entsize ? header->sh_size / header->sh_entsize : 0;
    symbols = calloc(count + 1, sizeof *symbols);
    for (size_t i = 0; symbols && i < count; i++) {
        GElf_Sym symbol;
        if (!gelf_getsym(data, (int)i, &symbol)) continue;
        if (symbol.st_value < DATA_SPACE || symbol.st_value >= EEPROM_SPACE) continue;
        const char *name = elf_strptr(elf, header->sh_link, symbol.st_name);
        if (!name || !*name) continue;
        symbols[symbol_count].name = strdup(name);
        symbols[symbol_count].address = (uint32_t)(symbol.st_value - DATA_SPACE);
        symbols[symbol_count++].size = (uint32_t)symbol.st_size;
    }
    const struct symbol *end = firmware_symbol("__heap_start");
    if (!end) end = firmware_symbol("_end");
    if (end) data_end = end->address;
    end = firmware_symbol("__brkval");
    if (end && end->address < board.avr->ramend) board.heap_end_place = end->address;
}

static const char *load_segments(Elf *elf) {
    size_t count = 0, size = 0;
    uint8_t *file = (uint8_t *)elf_rawfile(elf, &size);
    uint32_t code_end = 0;
    elf_getphdrnum(elf, &count);
    for (size_t i = 0; i < count; i++) {
        GElf_Phdr segment;
        if (!gelf_getphdr(elf, (int)i, &segment) || segment.p_type != PT_LOAD || !segment.p_filesz) continue;
        if (segment.p_offset > size || segment.p_filesz > size - segment.p_offset) return "the file is cut short";
        uint32_t address = (uint32_t)segment.p_paddr;
        uint8_t *bytes = file + segment.p_offset;
        if (address < DATA_SPACE) {
            if (!to_flash(address, bytes, segment.p_filesz)) return "the program is larger than the board's flash";
            if (segment.p_vaddr < DATA_SPACE && address + segment.p_filesz > code_end)
                code_end = address + (uint32_t)segment.p_filesz;
        } else if (address >= EEPROM_SPACE && address < FUSE_SPACE) {
            if (!to_eeprom(address - EEPROM_SPACE, bytes, segment.p_filesz))
                return "its EEPROM content is larger than the board's EEPROM";
        }
    }
    if (!code_end) return "it contains no program";
    board.avr->codeend = code_end;
    return NULL;
}

static const char *load_elf(int file) {
    /* Return addresses have three bytes only in avr-gcc's architecture 6, that of the Mega's chip. */
    unsigned wanted = board.avr->address_size == 3 ? 6 : 5;
    const char *error = NULL;
    elf_version(EV_CURRENT);
    Elf *elf = elf_begin(file, ELF_C_READ, NULL);
    GElf_Ehdr header;
    if (!elf || elf_kind(elf) != ELF_K_ELF || !gelf_getehdr(elf, &header))
        error = "it is not an ELF file";
    else if (header.e_machine != EM_AVR)
        error = "it is not a program for an AVR";
    else if ((header.e_flags & ARCHITECTURE_MASK) != wanted)
        error = "it was built for another chip";
    else
        error = load_segments(elf);
    for (Elf_Scn *section = NULL; !error && (section = elf_nextscn(elf, section));) {
        GElf_Shdr section_header;
        if (gelf_getshdr(section, &section_header) && section_header.sh_type == SHT_SYMTAB && !symbols)
            read_symbols(elf, section, &section_header);
    }
    elf_end(elf);
    return error;
}

/* Reads one record; returns the number of data bytes, or -1 for an invalid record. */
static int read_record(const char *line, uint8_t *record) {
    int count = 0, sum = 0;
    unsigned byte;
    if (*line++ != ':') return -1;
    for (; count < 260 && sscanf(line, "%2x", &byte) == 1; line += 2) {
        record[count++] = (uint8_t)byte;
        sum += (int)byte;
    }
    return count >= 5 && count == record[0] + 5 && (sum & 0xff) == 0 ? record[0] : -1;
}

static const char *load_hex(FILE *file) {
    char line[600];
    uint8_t record[300];
    uint32_t upper = 0;
    bool any = false;
    while (fgets(line, sizeof line, file)) {
        int count = read_record(line, record);
        if (count < 0) return "it is neither an ELF file nor a whole Intel HEX file";
        any = true;
        uint32_t address = upper + (uint32_t)(record[1] << 8 | record[2]);
        if (record[3] == 1) return board.avr->codeend ? NULL : "it contains no program";
        if (record[3] == 2) upper = (uint32_t)(record[4] << 8 | record[5]) << 4;
        if (record[3] == 4) upper = (uint32_t)(record[4] << 8 | record[5]) << 16;
        if (record[3] != 0) continue;
        if (!to_flash(address, record + 4, (size_t)count)) return "the program is larger than the board's flash";
        if (address + (uint32_t)count > board.avr->codeend) board.avr->codeend = address + (uint32_t)count;
    }
    return any ? "the file is cut short" : "it is empty";
}

bool firmware_load(const char *path, char *error, size_t room) {
    char magic[4] = {0};
    FILE *file = fopen(path, "rb");
    board.avr->codeend = 0;
    data_end = board.avr->ioend + 1u;
    if (!file) {
        snprintf(error, room, "%s cannot be read", path);
        return false;
    }
    size_t count = fread(magic, 1, sizeof magic, file);
    rewind(file);
    const char *reason =
        count == 4 && memcmp(magic, "\177ELF", 4) == 0 ? load_elf(fileno(file)) : load_hex(file);
    fclose(file);
    if (reason) snprintf(error, room, "%s cannot run on the %s: %s", path, board.kind->name, reason);
    return reason == NULL;
}
