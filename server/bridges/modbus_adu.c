#include "bridges/modbus_adu.h"

#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "bridges/modbus_ident.h"

enum pel_err pel_modbus_responder_init(struct pel_modbus_responder *a,
                                       struct pel_fault *fault)
{
    *a = (struct pel_modbus_responder){ .ends = { -1, -1 } };
    /* Sequential packets: one answer is one read. */
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0,
                   a->ends) != 0) {
        return pel_fault_set(fault, PEL_ERR_IO, "modbus: socketpair: %s",
                             strerror(errno));
    }
    a->context = modbus_new_tcp("127.0.0.1", MODBUS_TCP_DEFAULT_PORT);
    a->mapping = modbus_mapping_new(PEL_COIL_COUNT, PEL_DISCRETE_COUNT,
                                    PEL_HOLDING_COUNT, PEL_INPUT_COUNT);
    if (!a->context || !a->mapping) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "modbus: %s",
                             modbus_strerror(errno));
    }
    modbus_set_socket(a->context, a->ends[0]);
    /* It sleeps this long before some of its refusals. */
    modbus_set_response_timeout(a->context, 0, 1);
    return PEL_OK;
}

void pel_modbus_responder_finish(struct pel_modbus_responder *a)
{
    modbus_mapping_free(a->mapping);
    modbus_free(a->context);
    for (int i = 0; i < 2; i++) {
        if (a->ends[i] >= 0) {
            close(a->ends[i]);
        }
    }
}

static unsigned word_at(const uint8_t *bytes)
{
    return (unsigned)bytes[0] << 8 | bytes[1];
}

/* What a request asks, once its form is right. */
struct request {
    enum pel_register_space space;
    bool reads, writes;
    unsigned read_at, read_count, write_at, write_count;
    uint16_t words[MODBUS_MAX_WRITE_BITS];
};

static bool inside(enum pel_register_space space, unsigned at, unsigned count)
{
    static const unsigned sizes[] = { PEL_HOLDING_COUNT, PEL_INPUT_COUNT,
                                      PEL_DISCRETE_COUNT, PEL_COIL_COUNT };
    return at + count <= sizes[space];
}

static enum pel_modbus_exception parse_read(struct request *r,
                                            const uint8_t *pdu, size_t size)
{
    static const enum pel_register_space spaces[] = {
        [MODBUS_FC_READ_COILS] = PEL_SPACE_COIL,
        [MODBUS_FC_READ_DISCRETE_INPUTS] = PEL_SPACE_DISCRETE,
        [MODBUS_FC_READ_HOLDING_REGISTERS] = PEL_SPACE_HOLDING,
        [MODBUS_FC_READ_INPUT_REGISTERS] = PEL_SPACE_INPUT,
    };
    bool bits = pdu[0] <= MODBUS_FC_READ_DISCRETE_INPUTS;
    if (size != 5) {
        return PEL_MODBUS_ILLEGAL_VALUE;
    }
    r->space = spaces[pdu[0]];
    r->reads = true;
    r->read_at = word_at(pdu + 1);
    r->read_count = word_at(pdu + 3);
    return r->read_count == 0 ||
                   r->read_count >
                       (bits ? MODBUS_MAX_READ_BITS : MODBUS_MAX_READ_REGISTERS)
               ? PEL_MODBUS_ILLEGAL_VALUE
               : PEL_MODBUS_DONE;
}

static enum pel_modbus_exception parse_single(struct request *r,
                                              const uint8_t *pdu, size_t size)
{
    bool coil = pdu[0] == MODBUS_FC_WRITE_SINGLE_COIL;
    if (size != 5) {
        return PEL_MODBUS_ILLEGAL_VALUE;
    }
    unsigned value = word_at(pdu + 3);
    if (coil && value != 0 && value != 0xff00) {
        return PEL_MODBUS_ILLEGAL_VALUE;
    }
    r->space = coil ? PEL_SPACE_COIL : PEL_SPACE_HOLDING;
    r->writes = true;
    r->write_at = word_at(pdu + 1);
    r->write_count = 1;
    r->words[0] = (uint16_t)(coil ? value != 0 : value);
    return PEL_MODBUS_DONE;
}

/* Address, count, byte count and values from `body` on, `size` bytes. */
static enum pel_modbus_exception parse_values(struct request *r,
                                              const uint8_t *body, size_t size,
                                              bool bits, unsigned max)
{
    if (size < 5) {
        return PEL_MODBUS_ILLEGAL_VALUE;
    }
    r->space = bits ? PEL_SPACE_COIL : PEL_SPACE_HOLDING;
    r->writes = true;
    r->write_at = word_at(body);
    r->write_count = word_at(body + 2);
    size_t bytes = bits ? (r->write_count + 7) / 8 : r->write_count * 2;
    if (r->write_count == 0 || r->write_count > max || body[4] != bytes ||
        size != 5 + bytes) {
        return PEL_MODBUS_ILLEGAL_VALUE;
    }
    for (unsigned i = 0; i < r->write_count; i++) {
        r->words[i] = (uint16_t)(bits ? body[5 + i / 8] >> i % 8 & 1
                                      : word_at(body + 5 + 2 * i));
    }
    return PEL_MODBUS_DONE;
}

static enum pel_modbus_exception parse_mask(struct request *r,
                                            struct pel_modbus_map *map,
                                            const uint8_t *pdu, size_t size)
{
    if (size != 7) {
        return PEL_MODBUS_ILLEGAL_VALUE;
    }
    uint16_t now;
    r->space = PEL_SPACE_HOLDING;
    r->write_at = word_at(pdu + 1);
    r->write_count = 1;
    r->writes = true;
    if (!inside(r->space, r->write_at, 1)) {
        return PEL_MODBUS_ILLEGAL_ADDRESS;
    }
    pel_modbus_map_read(map, r->space, r->write_at, 1, &now);
    unsigned keep = word_at(pdu + 3), set = word_at(pdu + 5);
    r->words[0] = (uint16_t)((now & keep) | (set & ~keep));
    return PEL_MODBUS_DONE;
}

static enum pel_modbus_exception parse(struct request *r,
                                       struct pel_modbus_map *map,
                                       const uint8_t *pdu, size_t size)
{
    enum pel_modbus_exception code;
    switch (pdu[0]) {
    case MODBUS_FC_READ_COILS:
    case MODBUS_FC_READ_DISCRETE_INPUTS:
    case MODBUS_FC_READ_HOLDING_REGISTERS:
    case MODBUS_FC_READ_INPUT_REGISTERS:
        return parse_read(r, pdu, size);
    case MODBUS_FC_WRITE_SINGLE_COIL:
    case MODBUS_FC_WRITE_SINGLE_REGISTER:
        return parse_single(r, pdu, size);
    case MODBUS_FC_WRITE_MULTIPLE_COILS:
        return parse_values(r, pdu + 1, size - 1, true, MODBUS_MAX_WRITE_BITS);
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
        return parse_values(r, pdu + 1, size - 1, false,
                            MODBUS_MAX_WRITE_REGISTERS);
    case MODBUS_FC_REPORT_SLAVE_ID:
        return size == 1 ? PEL_MODBUS_DONE : PEL_MODBUS_ILLEGAL_VALUE;
    case MODBUS_FC_MASK_WRITE_REGISTER:
        return parse_mask(r, map, pdu, size);
    case MODBUS_FC_WRITE_AND_READ_REGISTERS:
        if (size < 5) {
            return PEL_MODBUS_ILLEGAL_VALUE;
        }
        code = parse_values(r, pdu + 5, size - 5, false,
                            MODBUS_MAX_WR_WRITE_REGISTERS);
        r->reads = true;
        r->read_at = word_at(pdu + 1);
        r->read_count = word_at(pdu + 3);
        return r->read_count == 0 ||
                       r->read_count > MODBUS_MAX_WR_READ_REGISTERS
                   ? PEL_MODBUS_ILLEGAL_VALUE
                   : code;
    default:
        return PEL_MODBUS_ILLEGAL_FUNCTION;
    }
}

/* Puts the values asked for where libmodbus reads them. */
static void fill_mapping(struct pel_modbus_responder *a,
                         struct pel_modbus_map *map, const struct request *r)
{
    uint16_t words[MODBUS_MAX_READ_BITS];
    pel_modbus_map_read(map, r->space, r->read_at, r->read_count, words);
    for (unsigned i = 0; i < r->read_count; i++) {
        switch (r->space) {
        case PEL_SPACE_HOLDING:
            a->mapping->tab_registers[r->read_at + i] = words[i];
            break;
        case PEL_SPACE_INPUT:
            a->mapping->tab_input_registers[r->read_at + i] = words[i];
            break;
        case PEL_SPACE_DISCRETE:
            a->mapping->tab_input_bits[r->read_at + i] = words[i] != 0;
            break;
        case PEL_SPACE_COIL:
            a->mapping->tab_bits[r->read_at + i] = words[i] != 0;
            break;
        }
    }
}

static size_t take_answer(struct pel_modbus_responder *a, uint8_t *answer)
{
    ssize_t size = recv(a->ends[1], answer, PEL_MODBUS_MAX_ADU, MSG_DONTWAIT);
    return size > 0 ? (size_t)size : 0;
}

size_t pel_modbus_refuse(struct pel_modbus_responder *a, const uint8_t *adu,
                         enum pel_modbus_exception code, uint8_t *answer)
{
    modbus_reply_exception(a->context, adu, code);
    size_t size = take_answer(a, answer);
    if (size > PEL_MODBUS_HEADER) {
        answer[PEL_MODBUS_HEADER] |= 0x80; /* it adds, which wraps */
    }
    return size;
}

size_t pel_modbus_answer(struct pel_modbus_responder *a,
                         struct pel_modbus_map *map, const uint8_t *adu,
                         size_t size, uint8_t *answer,
                         enum pel_modbus_exception *code)
{
    struct request r = { 0 };
    if (adu[PEL_MODBUS_HEADER] == PEL_MODBUS_FC_ENCAPSULATED) {
        size_t length = pel_modbus_identify(adu, size, answer, code);
        return length > 0 ? length : pel_modbus_refuse(a, adu, *code, answer);
    }
    *code = parse(&r, map, adu + PEL_MODBUS_HEADER, size - PEL_MODBUS_HEADER);
    if (!*code && ((r.reads && !inside(r.space, r.read_at, r.read_count)) ||
                   (r.writes && !inside(r.space, r.write_at, r.write_count)))) {
        *code = PEL_MODBUS_ILLEGAL_ADDRESS;
    }
    if (!*code && r.writes) {
        *code = pel_modbus_map_write(map, r.space, r.write_at, r.write_count,
                                     r.words);
    }
    if (*code) {
        return pel_modbus_refuse(a, adu, *code, answer);
    }
    if (r.reads) {
        fill_mapping(a, map, &r);
    }
    modbus_reply(a->context, adu, (int)size, a->mapping);
    return take_answer(a, answer);
}
