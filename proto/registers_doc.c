/* Prints proto/registers.md from registers.def and the schema. */
#include <stdio.h>
#include <string.h>

#include "fields.h"
#include "path.h"
#include "registers.h"

static const char *const type_names[] = {
    [PEL_TYPE_BIT] = "bit", [PEL_TYPE_U16] = "u16", [PEL_TYPE_I16] = "i16",
    [PEL_TYPE_U32] = "u32", [PEL_TYPE_I32] = "i32", [PEL_TYPE_F32] = "f32",
    [PEL_TYPE_F64] = "f64",
};

static const char introduction[] =
    "# Modbus registers\n"
    "\n"
    "Made from `registers.def` and the schema by `make registers`; do not "
    "edit.\n"
    "\n"
    "`pelagosd` serves Modbus/TCP on 127.0.0.1:1502 (`--modbus`). It answers "
    "units 0, 1 and 255, or those of `--modbus-units`; others get "
    "exception 11. Functions: 1, 2, 3, 4, 5, 6, 15, 16, 17, 22, 23.\n"
    "\n"
    "**Addresses** count from 0 as on the wire; `mbpoll` and consoles that "
    "write 40001 for the first holding register count from 1.\n"
    "\n"
    "**Numbers.** u16, i16: one register; u32, i32, f32 (IEEE 754): two; f64: "
    "four. The most significant register comes first (ABCD); "
    "`--modbus-order` cdab, badc or dcba changes that. Read the probe: it is "
    "right when you see 0x01020304 and 3.5. A value that is not there (a view "
    "that does not exist) reads as not-a-number in floats, the least number "
    "in i32, the greatest in u16 and u32. Reserved registers read as 0.\n"
    "\n"
    "**Writing.** Values are staged and can be read back at once; all of them "
    "take effect together, in one frame, when 1 is written to a commit "
    "register, by itself or as part of the same write-multiple request. The "
    "stage is one for all connections to a unit. A value outside its range, "
    "not a "
    "number, or not whole gets exception 3; an address that is not there, "
    "reserved, read only, or half of a value exception 2; then nothing of the "
    "request is staged. Angles are degrees, true and clockwise from north; "
    "heel is positive starboard down, trim bow up. An edit of own ship "
    "(entity 1) starts from where it is reckoned to be at that moment.\n"
    "\n"
    "**Heartbeat.** From the first write to register 4 on, silence for longer "
    "than `--modbus-heartbeat` (1000 ms) makes the source stale: an alarm, "
    "and own ship is extrapolated for `--modbus-extrapolate` (5000 ms); then, "
    "if Modbus steered it, it is stopped where it is, and the fields of "
    "`--modbus-safe` are set (`views.bridge.yaw=0,views.bridge.pitch=0`: a "
    "safe view). `sources.modbusStale` says so in the state and with every "
    "picture.\n"
    "\n"
    "**Connections.** At most `--modbus-clients` (32) are open; one more takes "
    "the place of one that has been idle for 60 s, else it is closed at once. "
    "A request may come in pieces, as slow serial gateways send it, but must "
    "be whole 5 s after its first byte; an answer must be taken within 5 s. "
    "What is slower, and what is not Modbus/TCP, closes its connection and is "
    "counted and logged: `pelagos_modbus_late_total` (MBS-010), "
    "`pelagos_modbus_stalled_total` (MBS-011), "
    "`pelagos_modbus_malformed_total` (MBS-007).\n"
    "\n"
    "**Units.** `--modbus-units 1,2:cdab:7:1` has several consoles on one "
    "port: each UNIT[:ORDER[:ENTITY[:VIEW]]] has its own word order, stage, "
    "heartbeat and status; its registers of entity 1 mean ENTITY, and those "
    "of views[0] the view of index VIEW, views[1] the one after.\n"
    "\n"
    "```\n"
    "# wind 14.5 m/s from 240 deg, then the commit (-0: addresses from 0)\n"
    "mbpoll -m tcp -p 1502 -a 1 -0 -r 10 -t 4:float -B 127.0.0.1 14.5 240\n"
    "mbpoll -m tcp -p 1502 -a 1 -0 -r 5 -t 4 127.0.0.1 1\n"
    "```\n";

static void print_field(const struct pel_register *reg)
{
    struct pel_path_info info;
    char path[96];
    int view;
    if (pel_register_path(reg, "x", path, sizeof path, &view) != PEL_OK ||
        pel_path_find(path, &info, NULL) != PEL_OK) {
        printf("? | ? | `%s` is not in the schema |\n", reg->path);
        return;
    }
    if (reg->scale != 1) {
        printf("%g ", reg->scale);
    }
    printf("%s | ", info.info->unit ? info.info->unit : "");
    if (info.field->type == PROTOBUF_C_TYPE_ENUM) {
        const ProtobufCEnumDescriptor *values = info.field->descriptor;
        for (unsigned i = 0; i < values->n_values; i++) {
            printf("%s%d %s", i ? ", " : "", values->values[i].value,
                   values->values[i].name);
        }
    } else if (info.field->type == PROTOBUF_C_TYPE_BOOL) {
        printf("0 no, 1 yes");
    } else if (info.info->ranged) {
        printf("%.10g … %.10g", info.info->minimum, info.info->maximum);
    }
    printf(" | `%s`: %s |\n", reg->path, info.info->doc);
}

static void print_space(enum pel_register_space space, const char *title)
{
    bool words = space == PEL_SPACE_HOLDING || space == PEL_SPACE_INPUT;
    printf("\n## %s\n\n", title);
    printf(words ? "| address | type | unit | range | what |\n"
                   "|---:|---|---|---|---|\n"
                 : "| address | what |\n|---:|---|\n");
    for (size_t i = 0; i < pel_register_count; i++) {
        const struct pel_register *reg = &pel_registers[i];
        if (reg->space != space) {
            continue;
        }
        printf("| %u | ", reg->address);
        if (words) {
            printf("%s | ", type_names[reg->type]);
        }
        if (reg->source == PEL_SOURCE_PATH) {
            print_field(reg);
        } else if (words) {
            printf("%s | | %s |\n", reg->unit ? reg->unit : "", reg->doc);
        } else {
            printf("%s |\n", reg->doc);
        }
    }
}

int main(void)
{
    fputs(introduction, stdout);
    print_space(PEL_SPACE_HOLDING, "Holding registers");
    print_space(PEL_SPACE_INPUT, "Input registers");
    print_space(PEL_SPACE_DISCRETE, "Discrete inputs");
    print_space(PEL_SPACE_COIL, "Coils");
    return 0;
}
