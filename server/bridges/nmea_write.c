#include "bridges/nmea_write.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "base/vec.h"

void pel_nmea_say(struct pel_nmea_writer *w, char start, const char *format,
                  ...)
{
    char body[80];
    unsigned sum = 0;
    va_list args;
    va_start(args, format);
    int length = vsnprintf(body, sizeof body, format, args);
    va_end(args);
    if (length < 0 || length > 76 || w->used + (size_t)length + 7 > w->size) {
        return;
    }
    for (int i = 0; i < length; i++) {
        sum ^= (unsigned char)body[i];
    }
    w->used += (size_t)snprintf(w->out + w->used, w->size - w->used,
                                "%c%s*%02X\r\n", start, body, sum);
    w->count++;
}

double pel_nmea_bearing(double degrees)
{
    return pel_bearing_deg(degrees, 1);
}
