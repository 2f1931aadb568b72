#include "error.h"

#include <stdarg.h>
#include <stdio.h>

enum pel_client_code(client_fail)(struct pel_client_error *error,
                                  enum pel_client_code code, const char *format,
                                  ...)
{
    if (error) {
        *error = (struct pel_client_error){ .code = code, .minimum = 1 };
        va_list args;
        va_start(args, format);
        vsnprintf(error->message, sizeof error->message, format, args);
        va_end(args);
    }
    return code;
}
