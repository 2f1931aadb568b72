/* Prints proto/registers.md: the text of standard input, then the tables of
 * registers.def, with the units and ranges that the schema gives their fields;
 * proto/manual.md says what each field means. */
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

static void print_field(const struct pel_register *reg)
{
    struct pel_path_info info;
    char path[96];
    int view;
    if (pel_register_path(reg, "x", path, sizeof path, &view) != PEL_OK ||
        pel_path_find(path, &info, NULL) != PEL_OK) {
        printf("? | `%s` is not in the schema |\n", reg->path);
        return;
    }
    const char *unit = info.info->unit ? info.info->unit : "";
    if (reg->scale != 1) {
        printf(" %g", reg->scale);
    }
    if (unit[0] && strcmp(unit, "1") != 0) {
        printf(" %s", unit);
    }
    printf("%s", info.info->ranged ? ", " : "");
    if (info.field->type == PROTOBUF_C_TYPE_ENUM) {
        const ProtobufCEnumDescriptor *values = info.field->descriptor;
        for (unsigned i = 0; i < values->n_values; i++) {
            printf(", %d %s", values->values[i].value, values->values[i].name);
        }
    } else if (info.field->type == PROTOBUF_C_TYPE_BOOL) {
        printf(", 0 no, 1 yes");
    } else if (info.info->ranged) {
        printf("%.10g..%.10g", info.info->minimum, info.info->maximum);
    }
    printf(" | `%s` |\n", reg->path);
}

static void print_space(enum pel_register_space space, const char *title)
{
    bool words = space == PEL_SPACE_HOLDING || space == PEL_SPACE_INPUT;
    printf("\n## %s\n\n", title);
    printf(words ? "| address | form | meaning |\n|---:|---|---|\n"
                 : "| address | meaning |\n|---:|---|\n");
    for (size_t i = 0; i < pel_register_count; i++) {
        const struct pel_register *reg = &pel_registers[i];
        if (reg->space != space) {
            continue;
        }
        printf("| %u | ", reg->address);
        if (words) {
            printf("%s", type_names[reg->type]);
        }
        if (reg->source == PEL_SOURCE_PATH) {
            print_field(reg);
        } else if (words) {
            printf("%s%s | %s |\n", reg->unit ? " " : "",
                   reg->unit ? reg->unit : "", reg->doc);
        } else {
            printf("%s |\n", reg->doc);
        }
    }
}

int main(void)
{
    for (int c; (c = getchar()) != EOF;) {
        putchar(c);
    }
    print_space(PEL_SPACE_HOLDING, "Holding registers");
    print_space(PEL_SPACE_INPUT, "Input registers");
    print_space(PEL_SPACE_DISCRETE, "Discrete inputs");
    print_space(PEL_SPACE_COIL, "Coils");
    return 0;
}
