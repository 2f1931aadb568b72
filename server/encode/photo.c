#include "encode/photo.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/vec.h"

/* CIPA DC-008 (EXIF 2.32). A tag's value of more than four bytes stands behind
 * the directories. */
enum type {
    BYTE = 1,
    ASCII = 2,
    SHORT = 3,
    LONG = 4,
    RATIONAL = 5,
    UNDEFINED = 7,
    SIGNED = 10
};

#define MOST_TAGS 32
#define MOST_VALUES 640

struct directory {
    int count;
    struct {
        uint16_t tag, type;
        uint32_t number, at; /* at: of `values` */
        uint32_t size;
    } tags[MOST_TAGS];
    unsigned char values[MOST_VALUES];
    uint32_t size;
};

static void put16(unsigned char *to, uint32_t v)
{
    to[0] = (unsigned char)v;
    to[1] = (unsigned char)(v >> 8);
}

static void put32(unsigned char *to, uint32_t v)
{
    put16(to, v);
    put16(to + 2, v >> 16);
}

/* In rising order of tags. What does not fit is left out. */
static void add(struct directory *d, uint16_t tag, enum type type,
                uint32_t number, const void *value, uint32_t size)
{
    if (d->count == MOST_TAGS || size > MOST_VALUES - d->size) {
        return;
    }
    memcpy(d->values + d->size, value, size);
    d->tags[d->count].tag = tag;
    d->tags[d->count].type = (uint16_t)type;
    d->tags[d->count].number = number;
    d->tags[d->count].at = d->size;
    d->tags[d->count++].size = size;
    d->size += size + (size & 1);
}

static void add_text(struct directory *d, uint16_t tag, const char *text)
{
    uint32_t size = (uint32_t)strlen(text) + 1;
    add(d, tag, ASCII, size, text, size);
}

static void add_short(struct directory *d, uint16_t tag, uint32_t v)
{
    unsigned char bytes[2];
    put16(bytes, v);
    add(d, tag, SHORT, 1, bytes, 2);
}

static void add_long(struct directory *d, uint16_t tag, uint32_t v)
{
    unsigned char bytes[4];
    put32(bytes, v);
    add(d, tag, LONG, 1, bytes, 4);
}

static void add_rationals(struct directory *d, uint16_t tag, enum type type,
                          const double *v, uint32_t count, double unit)
{
    unsigned char bytes[24];
    for (uint32_t i = 0; i < count; i++) {
        if (!(fabs(v[i]) * unit < 2147483647.0)) {
            return;
        }
        put32(bytes + 8 * i, (uint32_t)(int32_t)llround(v[i] * unit));
        put32(bytes + 8 * i + 4, (uint32_t)unit);
    }
    add(d, tag, type, count, bytes, 8 * count);
}

/* Degrees, minutes, seconds to 1e-5 of a second. */
static void add_angle(struct directory *d, uint16_t tag, double degrees)
{
    double all = round(fabs(degrees) * 3.6e8) / 1e5; /* seconds */
    double whole = floor(all / 3600.0),
           minutes = floor(all / 60.0) - 60.0 * whole;
    double v[3] = { whole, minutes, all - 3600.0 * whole - 60.0 * minutes };
    if (all < 3600.0 * 360.0) {
        add_rationals(d, tag, RATIONAL, v, 3, 1e5);
    }
}

static uint32_t directory_size(const struct directory *d)
{
    return 2 + 12 * (uint32_t)d->count + 4 + d->size;
}

/* The directory at `at` of the block; returns what is behind it. */
static uint32_t lay(const struct directory *d, unsigned char *block,
                    uint32_t at)
{
    unsigned char *p = block + at;
    uint32_t values = at + 2 + 12 * (uint32_t)d->count + 4;
    put16(p, (uint32_t)d->count);
    for (int i = 0; i < d->count; i++) {
        unsigned char *entry = p + 2 + 12 * i;
        put16(entry, d->tags[i].tag);
        put16(entry + 2, d->tags[i].type);
        put32(entry + 4, d->tags[i].number);
        put32(entry + 8, 0);
        if (d->tags[i].size <= 4) {
            memcpy(entry + 8, d->values + d->tags[i].at, d->tags[i].size);
        } else {
            put32(entry + 8, values + d->tags[i].at);
        }
    }
    put32(p + 2 + 12 * d->count, 0); /* no next one */
    memcpy(block + values, d->values, d->size);
    return values + d->size;
}

struct moment {
    bool known;
    struct tm utc;
    int hundredths;
};

static struct moment moment_of(double unix_s)
{
    struct moment m = { 0 };
    double rounded = floor(unix_s * 100.0 + 0.5);
    if (rounded >= 0.0 && rounded < 253402300800e2) {
        time_t seconds = (time_t)floor(rounded / 100.0);
        m.known = gmtime_r(&seconds, &m.utc) != NULL;
        m.hundredths = (int)(rounded - 100.0 * (double)seconds);
    }
    return m;
}

/* Of a frame of 36 mm width. */
static double focal_mm(const struct pel_photo *p)
{
    double f = 18.0 / tan(0.5 * p->horizontal_fov_deg * (M_PI / 180.0));
    return isfinite(f) && f > 0.0 && f < 60000.0 ? f : 0.0;
}

static void list_place(const struct pel_photo *p, const struct moment *m,
                       struct directory *gps)
{
    static const unsigned char version[4] = { 2, 3, 0, 0 };
    double altitude = fabs(p->altitude_m);
    unsigned char below = p->altitude_m < 0.0;
    add(gps, 0x00, BYTE, 4, version, 4);
    add_text(gps, 0x01, p->latitude_deg < 0.0 ? "S" : "N");
    add_angle(gps, 0x02, p->latitude_deg);
    add_text(gps, 0x03, p->longitude_deg < 0.0 ? "W" : "E");
    add_angle(gps, 0x04, p->longitude_deg);
    add(gps, 0x05, BYTE, 1, &below, 1);
    /* A rational holds 2,147 km of millimetres. */
    add_rationals(gps, 0x06, RATIONAL, &altitude, 1,
                  altitude < 2e6 ? 1000.0 : 100.0);
    if (m->known) {
        double t[3] = { m->utc.tm_hour, m->utc.tm_min,
                        m->utc.tm_sec + 0.01 * m->hundredths };
        add_rationals(gps, 0x07, RATIONAL, t, 3, 100.0);
    }
    add_text(gps, 0x10, "T");
    /* 0.00 to 359.99, as Exif has it. */
    double heading = pel_bearing_deg(p->heading_deg, 2);
    add_rationals(gps, 0x11, RATIONAL, &heading, 1, 100.0);
    add_text(gps, 0x12, "WGS-84");
    if (m->known) {
        char date[32];
        strftime(date, sizeof date, "%Y:%m:%d", &m->utc);
        add_text(gps, 0x1d, date);
    }
}

static void list_picture(const struct pel_photo *p, const struct moment *m,
                         struct directory *exif)
{
    char date[32], hundredths[12];
    if (m->known) {
        strftime(date, sizeof date, "%Y:%m:%d %H:%M:%S", &m->utc);
    }
    add(exif, 0x9000, UNDEFINED, 4, "0232", 4);
    if (m->known) {
        snprintf(hundredths, sizeof hundredths, "%02d", m->hundredths);
        add_text(exif, 0x9003, date);     /* DateTimeOriginal */
        add_text(exif, 0x9011, "+00:00"); /* OffsetTimeOriginal */
        add_text(exif, 0x9291, hundredths);
    }
    add_short(exif, 0xa001, 1); /* sRGB */
    add_long(exif, 0xa002, p->width);
    add_long(exif, 0xa003, p->height);
    if (focal_mm(p) >= 1.0) {
        add_short(exif, 0xa405, (uint32_t)lround(focal_mm(p)));
    }
}

static void write_exif(const struct pel_photo *p, const struct moment *m,
                       struct pel_photo_blocks *out)
{
    struct directory first = { 0 }, exif = { 0 }, gps = { 0 };
    char name[100], date[32], software[64];
    snprintf(name, sizeof name, "%.64s", p->view);
    snprintf(software, sizeof software, "%.63s", p->software);
    list_picture(p, m, &exif);
    list_place(p, m, &gps);
    add_text(&first, 0x010e, name); /* ImageDescription */
    add_text(&first, 0x010f, "Pelagos");
    add_text(&first, 0x0131, software);
    if (m->known) {
        strftime(date, sizeof date, "%Y:%m:%d %H:%M:%S", &m->utc);
        add_text(&first, 0x0132, date);
    }
    uint32_t at = 8 + directory_size(&first) + 2 * (12 + 4); /* with these */
    add_long(&first, 0x8769, at);
    add_long(&first, 0x8825, at + directory_size(&exif));
    memcpy(out->exif, "II*\0\10\0\0\0", 8);
    lay(&first, out->exif, 8);
    lay(&exif, out->exif, at);
    out->exif_size = lay(&gps, out->exif, at + directory_size(&exif));
}

static void escape(const char *text, char *to, size_t size)
{
    size_t n = 0;
    for (; *text && n + 7 < size; text++) {
        const char *as = *text == '&'   ? "&amp;"
                         : *text == '<' ? "&lt;"
                         : *text == '>' ? "&gt;"
                         : *text == '"' ? "&quot;"
                                        : NULL;
        if (as) {
            n += (size_t)snprintf(to + n, size - n, "%s", as);
        } else {
            to[n++] = *text;
        }
    }
    to[n] = '\0';
}

/* As XMP has a place: degrees, minutes with a fraction, the letter. */
static void angle_text(double degrees, const char letters[2], char out[32])
{
    double minutes = round(fabs(degrees) * 60.0 * 1e7) / 1e7;
    double whole = floor(minutes / 60.0);
    snprintf(out, 32, "%.0f,%.7f%c", whole, minutes - 60.0 * whole,
             letters[degrees < 0.0]);
}

static void write_xmp(const struct pel_photo *p, const struct moment *m,
                      struct pel_photo_blocks *out)
{
    char view[256], date[40] = "", latitude[32], longitude[32];
    escape(p->view, view, sizeof view);
    angle_text(p->latitude_deg, "NS", latitude);
    angle_text(p->longitude_deg, "EW", longitude);
    if (m->known) {
        char day[32];
        strftime(day, sizeof day, "%Y-%m-%dT%H:%M:%S", &m->utc);
        snprintf(date, sizeof date, "%s.%02dZ", day, m->hundredths);
    }
    int size = snprintf(
        out->xmp, sizeof out->xmp,
        "<?xpacket begin=\"\xef\xbb\xbf\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
        "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
        "<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
        "<rdf:Description rdf:about=\"\"\n"
        " xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\"\n"
        " xmlns:exif=\"http://ns.adobe.com/exif/1.0/\"\n"
        " xmlns:pelagos=\"https://pelagos.invalid/ns/1.0/\"\n"
        " xmp:CreatorTool=\"%s\"%s%s%s\n"
        " exif:GPSLatitude=\"%s\" exif:GPSLongitude=\"%s\"\n"
        " exif:GPSAltitude=\"%lld/1000\" exif:GPSAltitudeRef=\"%d\"\n"
        " exif:GPSMapDatum=\"WGS-84\"\n"
        " pelagos:View=\"%s\" pelagos:Time=\"%.6f\"\n"
        " pelagos:Projection=\"rectilinear\"\n"
        " pelagos:Heading=\"%.6f\" pelagos:Pitch=\"%.6f\" "
        "pelagos:Roll=\"%.6f\"\n"
        " pelagos:HorizontalFieldOfView=\"%.6f\" "
        "pelagos:VerticalFieldOfView=\"%.6f\"\n"
        " pelagos:ExposureEV100=\"%.4f\"%s/>\n"
        "</rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"r\"?>",
        p->software, *date ? " xmp:CreateDate=\"" : "", date, *date ? "\"" : "",
        latitude, longitude, llround(fabs(p->altitude_m) * 1000.0),
        p->altitude_m < 0.0, view, p->time_s,
        pel_bearing_deg(p->heading_deg, 6), p->pitch_deg, p->roll_deg,
        p->horizontal_fov_deg, p->vertical_fov_deg, p->exposure_ev,
        p->in_ground ? " pelagos:Ground=\"inside\"" : "");
    out->xmp_size =
        size > 0 && (size_t)size < sizeof out->xmp ? (size_t)size : 0;
}

void pel_photo_write(const struct pel_photo *photo,
                     struct pel_photo_blocks *out)
{
    struct moment m = moment_of(photo->unix_s);
    write_exif(photo, &m, out);
    write_xmp(photo, &m, out);
}
