/* Prints proto/cigi.md: the text of standard input, then every packet and field
 * of the table. */
#include <stdio.h>
#include <string.h>

#include "bridges/cigi_packet.h"
#include "scene/spectra.h"

static void print_place(const struct pel_cigi_row *row)
{
    static const char *const types[] = {
        [PEL_CIGI_HEAD] = "",   [PEL_CIGI_U8] = "u8",   [PEL_CIGI_I8] = "i8",
        [PEL_CIGI_U16] = "u16", [PEL_CIGI_U32] = "u32", [PEL_CIGI_F32] = "f32",
        [PEL_CIGI_F64] = "f64", [PEL_CIGI_BITS] = "b"
    };
    printf("| %u %s", row->offset, types[row->type]);
    if (row->type == PEL_CIGI_BITS) {
        printf(row->bits > 1 ? "%d-%d" : "%d", row->shift,
               row->shift + row->bits - 1);
    }
}

/* What becomes of a field; one that is honoured needs no word of it. */
static void print_use(const struct pel_cigi_row *row)
{
    static const char *const grades[] = { "", "approximated", "ignored" };
    const char *grade = grades[row->grade];
    printf("%s%s%s", grade, grade[0] && row->note[0] ? ": " : "", row->note);
}

static void print_packet(const struct pel_cigi_info *info)
{
    printf("\n### %s (%u), %u bytes, %s\n\n", info->text, info->id, info->size,
           info->from_host ? "host to generator" : "generator to host");
    printf("| at | field | use |\n|---|---|---|\n");
    for (size_t f = info->first + 1u;
         f < PEL_CIGI_FIELD_COUNT && pel_cigi_rows[f].type != PEL_CIGI_HEAD;
         f++) {
        const struct pel_cigi_row *row = &pel_cigi_rows[f];
        print_place(row);
        printf(" | %s%s%s | ", row->text, row->unit[0] ? ", " : "", row->unit);
        print_use(row);
        printf(" |\n");
    }
}

/* {SpectrumKind} in the text: the numbers that a host may send. */
static void print_numbers(const char *name)
{
    const ProtobufCEnumDescriptor *enums[] = {
        &pelagos__spectrum_kind__descriptor, &pelagos__synthesiser__descriptor,
        &pelagos__navigation_status__descriptor
    };
    for (size_t e = 0; e < sizeof enums / sizeof *enums; e++) {
        bool spectra = enums[e] == &pelagos__spectrum_kind__descriptor;
        bool here = strcmp(enums[e]->short_name, name) == 0;
        for (unsigned i = 0; here && i < enums[e]->n_values; i++) {
            const ProtobufCEnumValue *v = &enums[e]->values[i];
            if (!spectra || !pel_spectrum_reads((Pelagos__SpectrumKind)v->value,
                                                "sea.measured")) {
                printf("%s%d %s", i > 0 ? ", " : "", v->value, v->name);
            }
        }
    }
}

int main(void)
{
    for (int c; (c = getchar()) != EOF;) {
        char name[32];
        if (c == '{' && scanf("%31[A-Za-z]}", name) == 1) {
            print_numbers(name);
        } else {
            putchar(c);
        }
    }
    printf("Offsets are bytes from the packet's begin, `b` bits of that byte "
           "from the low end; at 0 and 1 are the packet's id and size, and "
           "bytes not named are reserved and not read. A field is honoured "
           "unless its use says approximated or ignored. Packets that are "
           "not here are skipped and counted.\n");
    for (int k = 0; k < PEL_CIGI_KIND_COUNT; k++) {
        print_packet(&pel_cigi_packets[k]);
    }
    return 0;
}
