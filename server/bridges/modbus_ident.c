#include "bridges/modbus_ident.h"

#include <glib.h>
#include <string.h>

#define MOST_PDU 253
#define BASIC 1
#define ONE 4
#define CONFORMITY 0x82 /* regular objects, as a stream or one by one */
#define FIRST_REGULAR 3
#define HEAD 7 /* function, MEI, code, conformity, more, next, count */

/* By object id. */
static const char *object(size_t id)
{
    const char *const objects[] = {
        "Pelagos",
        "pelagosd",
        PEL_VERSION,
        "", /* no address of a vendor */
        "Pelagos ocean renderer",
        "Modbus server of a scene",
        g_get_host_name(),
    };
    return id < G_N_ELEMENTS(objects) ? objects[id] : NULL;
}

static size_t put(uint8_t *at, size_t room, size_t id)
{
    size_t length = strlen(object(id));
    length = length < 64 ? length : 64;
    if (room < 2 + length) {
        return 0;
    }
    at[0] = (uint8_t)id;
    at[1] = (uint8_t)length;
    memcpy(at + 2, object(id), length);
    return 2 + length;
}

size_t pel_modbus_identify(const uint8_t *adu, size_t size, uint8_t *answer,
                           enum pel_modbus_exception *code)
{
    const uint8_t *asked = adu + PEL_MODBUS_HEADER;
    uint8_t *pdu = answer + PEL_MODBUS_HEADER;
    size_t length = size - PEL_MODBUS_HEADER, used = HEAD;
    *code = length < 2 || asked[1] != PEL_MODBUS_MEI_IDENTIFY
                ? PEL_MODBUS_ILLEGAL_FUNCTION
            : length != 4 || asked[2] < BASIC || asked[2] > ONE
                ? PEL_MODBUS_ILLEGAL_VALUE
            : asked[2] == ONE && !object(asked[3]) ? PEL_MODBUS_ILLEGAL_ADDRESS
                                                   : PEL_MODBUS_DONE;
    if (*code) {
        return 0;
    }
    /* A stream begins with the object asked for, or with the first one if
     * there is no such object. */
    size_t end = asked[2] == ONE     ? asked[3] + 1U
                 : asked[2] == BASIC ? FIRST_REGULAR
                                     : 256;
    size_t id = asked[3] < end && object(asked[3]) ? asked[3] : 0;
    pdu[6] = 0;
    for (; id < end && object(id); id++) {
        size_t more = put(pdu + used, MOST_PDU - used, id);
        if (more == 0) {
            break;
        }
        used += more;
        pdu[6]++;
    }
    bool rest = asked[2] != ONE && id < end && object(id);
    pdu[0] = PEL_MODBUS_FC_ENCAPSULATED;
    pdu[1] = PEL_MODBUS_MEI_IDENTIFY;
    pdu[2] = asked[2];
    pdu[3] = CONFORMITY;
    pdu[4] = rest ? 0xff : 0;
    pdu[5] = rest ? (uint8_t)id : 0;
    memcpy(answer, adu, PEL_MODBUS_HEADER);
    answer[4] = (uint8_t)((used + 1) >> 8);
    answer[5] = (uint8_t)(used + 1);
    return PEL_MODBUS_HEADER + used;
}
