/* Prints proto/registers.md: the text of standard input, then the tables of
 * registers.def, with what the schema says of their fields. */
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
    for (int c; (c = getchar()) != EOF;) {
        putchar(c);
    }
    print_space(PEL_SPACE_HOLDING, "Holding registers");
    print_space(PEL_SPACE_INPUT, "Input registers");
    print_space(PEL_SPACE_DISCRETE, "Discrete inputs");
    print_space(PEL_SPACE_COIL, "Coils");
    return 0;
}
