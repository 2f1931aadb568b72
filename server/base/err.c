#include "base/err.h"

#include <stdarg.h>
#include <stdio.h>

#include "base/text.h"

const char *pel_err_name(enum pel_err err)
{
    switch (err) {
    case PEL_OK:
        return "OK";
    case PEL_ERR_MALFORMED:
        return "MALFORMED";
    case PEL_ERR_NOT_FOUND:
        return "NOT_FOUND";
    case PEL_ERR_OUT_OF_RANGE:
        return "OUT_OF_RANGE";
    case PEL_ERR_INVALID:
        return "INVALID";
    case PEL_ERR_CONFLICT:
        return "CONFLICT";
    case PEL_ERR_BUSY:
        return "BUSY";
    case PEL_ERR_UNAUTHORIZED:
        return "UNAUTHORIZED";
    case PEL_ERR_FORBIDDEN:
        return "FORBIDDEN";
    case PEL_ERR_FULL:
        return "IO";
    case PEL_ERR_IO:
    case PEL_ERR_GPU:
    case PEL_ERR_NO_MEMORY:
    case PEL_ERR_INTERNAL:
        break;
    }
    return "INTERNAL";
}

enum pel_err(pel_fault_set)(struct pel_fault *fault, enum pel_err code,
                            const char *format, ...)
{
    if (fault) {
        *fault = (struct pel_fault){ .code = code, .minimum = 1, .maximum = 0 };
        va_list args;
        va_start(args, format);
        vsnprintf(fault->message, sizeof fault->message, format, args);
        va_end(args);
        pel_text_clean(fault->message);
    }
    return code;
}

void pel_fault_clean(struct pel_fault *fault)
{
    pel_text_clean(fault->path);
    pel_text_clean(fault->value);
    pel_text_clean(fault->message);
}
