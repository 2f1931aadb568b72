#include "seabed/reader/meaning.h"

#include <ctype.h>
#include <math.h>
#include <ogr_srs_api.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/cf.h"

/* A US survey foot and a foot are 2e-6 apart, and both are called foot. */
#define ALIKE 1e-5

static void copy(char *to, size_t size, const char *from)
{
    snprintf(to, size, "%s", from ? from : "");
}

char pel_raster_letter(GDALDataType type)
{
    return type == GDT_Float64                       ? 'd'
           : type == GDT_Int16 || type == GDT_UInt16 ? 's'
           : type == GDT_Int32 || type == GDT_UInt32 ? 'l'
           : type == GDT_Byte                        ? 'b'
                                                     : 'f';
}

void pel_raster_said_by_band(GDALRasterBandH band, struct pel_raster_said *out)
{
    copy(out->name, sizeof out->name,
         GDALGetMetadataItem(band, "NETCDF_VARNAME", NULL));
    if (!*out->name) {
        copy(out->name, sizeof out->name, GDALGetDescription(band));
    }
    copy(out->standard, sizeof out->standard,
         GDALGetMetadataItem(band, "standard_name", NULL));
    copy(out->long_name, sizeof out->long_name,
         GDALGetMetadataItem(band, "long_name", NULL));
    copy(out->positive, sizeof out->positive,
         GDALGetMetadataItem(band, "positive", NULL));
    GDALDataType type = GDALGetRasterDataType(band);
    out->type = pel_raster_letter(type);
    copy(out->comment, sizeof out->comment,
         GDALGetMetadataItem(band, "comment", NULL));
    copy(out->unit, sizeof out->unit, GDALGetRasterUnitType(band));
    if (!*out->unit) {
        copy(out->unit, sizeof out->unit,
             GDALGetMetadataItem(band, "units", NULL));
    }
}

static bool begins(const char *text, const char *with)
{
    return strncasecmp(text, with, strlen(with)) == 0;
}

static bool has(const char *text, const char *word)
{
    size_t length = strlen(word);
    for (; *text; text++) {
        if (strncasecmp(text, word, length) == 0) {
            return true;
        }
    }
    return false;
}

/* CF's names of the bottom, and those of before CF that say it plainly. */
enum pel_raster_way pel_raster_way_of_name(const char *name)
{
    size_t length = strlen(name);
    if (begins(name, "sea_floor_depth") || begins(name, "depth") ||
        has(name, "sea_floor_depth_below") || begins(name, "water_depth")) {
        return PEL_RASTER_DOWN;
    }
    bool height =
        strcasecmp(name, "height") == 0 || strcasecmp(name, "elevation") == 0 ||
        begins(name, "height_above") || begins(name, "sea_floor_alt") ||
        (length >= 8 && strcasecmp(name + length - 8, "altitude") == 0);
    return height ? PEL_RASTER_UP : PEL_RASTER_AS_ASKED;
}

/* --- which way ------------------------------------------------------------ */

/* "down", "downwards", "Up"; in a text behind "positive". */
static enum pel_raster_way way_of_words(const struct pel_raster_said *said)
{
    const char *const texts[] = { said->positive, said->long_name,
                                  said->comment };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        const char *at = texts[i];
        for (; i > 0 && *at && !begins(at, "positive"); at++) {
        }
        at += i > 0 && *at ? strlen("positive") : 0;
        at += strspn(at, " -_:=(");
        if (begins(at, "down") || begins(at, "up")) {
            return begins(at, "down") ? PEL_RASTER_DOWN : PEL_RASTER_UP;
        }
    }
    return PEL_RASTER_AS_ASKED;
}

/* Whether its name or title calls it a depth, or its numbers soundings. */
static bool called_depth(const struct pel_raster_said *said)
{
    static const char *const words[] = { "depth", "bathy", "sounding" };
    static const char *const names[] = { "dep", "dpt", "dept", "deptho" };
    bool called = false;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        called = called || has(said->name, words[i]) ||
                 has(said->long_name, words[i]) || has(said->comment, words[i]);
    }
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        called = called || strcasecmp(said->name, names[i]) == 0;
    }
    return called;
}

struct vote {
    enum pel_raster_way way;
    char by[96];
};

static void vote_of_crs(OGRSpatialReferenceH srs, struct vote *out)
{
    OGRAxisOrientation axis = OAO_Other;
    if (!srs || !OSRIsVertical(srs) || !OSRGetAxis(srs, "VERT_CS", 0, &axis)) {
        return;
    }
    const char *name = OSRGetAttrValue(srs, "VERT_CS", 0);
    snprintf(out->by, sizeof out->by, "vertical CRS \"%.60s\"",
             name ? name : "?");
    out->way = axis == OAO_Down ? PEL_RASTER_DOWN
               : axis == OAO_Up ? PEL_RASTER_UP
                                : PEL_RASTER_AS_ASKED;
}

static const char *grow(enum pel_raster_way way)
{
    return way == PEL_RASTER_DOWN ? "downward" : "upward";
}

static enum pel_err find_way(const struct pel_raster_said *said,
                             OGRSpatialReferenceH srs, bool depths,
                             struct pel_raster_meaning *out,
                             struct pel_fault *fault)
{
    struct vote votes[3] = { { PEL_RASTER_AS_ASKED, "" } };
    const struct vote *told = NULL;
    votes[0].way = pel_raster_way_of_name(said->standard);
    snprintf(votes[0].by, sizeof votes[0].by, "standard_name %.70s",
             said->standard);
    votes[1].way = way_of_words(said);
    snprintf(votes[1].by, sizeof votes[1].by, "%s \"%.70s\"",
             *said->positive ? "positive" : "text",
             *said->positive  ? said->positive
             : *said->comment ? said->comment
                              : said->long_name);
    if (said->up_by_bag) {
        votes[2] = (struct vote){ PEL_RASTER_UP, "format BAG" };
    } else {
        vote_of_crs(srs, &votes[2]);
    }
    for (int i = 0; i < 3; i++) {
        if (votes[i].way == PEL_RASTER_AS_ASKED) {
            continue;
        }
        if (told && told->way != votes[i].way) {
            return pel_fault_set(
                fault, PEL_ERR_INVALID,
                "by its %.60s its numbers grow %s, by its %.60s %s: mend the "
                "wrong one, as by %s",
                told->by, grow(told->way), votes[i].by, grow(votes[i].way),
                said->netcdf ? "ncatted -a positive,VARIABLE,o,c,down FILE"
                             : "gdal_edit.py -a_srs EPSG:4326 FILE");
        }
        told = told ? told : &votes[i];
    }
    out->way = told                 ? told->way
               : called_depth(said) ? PEL_RASTER_BY_SIGN
                                    : PEL_RASTER_AS_ASKED;
    out->by_crs = told == &votes[2] && !said->up_by_bag;
    snprintf(out->why, sizeof out->why, "%s", told ? told->by : said->name);
    if (depths && out->way == PEL_RASTER_UP) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "seabed.values is DEPTH, and by its %.90s its "
                             "numbers are heights, upward: set seabed.values "
                             "ELEVATION",
                             told->by);
    }
    return PEL_OK;
}

enum pel_err pel_raster_sign(const struct pel_raster_meaning *m, bool depths,
                             double least, double greatest, double *factor,
                             struct pel_fault *fault)
{
    bool down = m->way == PEL_RASTER_DOWN || depths;
    if (m->way == PEL_RASTER_DOWN && greatest <= 0 && least < 0) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "by its %.90s its numbers grow downward, but none "
                             "is above 0: if they are heights say so, as by %s "
                             "FILE",
                             m->why,
                             m->by_crs ? "gdal_edit.py -a_srs EPSG:4326"
                                       : "ncatted -a standard_name,VARIABLE,o,"
                                         "c,altitude -a positive,VARIABLE,o,c,"
                                         "up");
    }
    if (depths && m->way != PEL_RASTER_DOWN && greatest <= 0 && least < 0) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "seabed.values is DEPTH, and none of its numbers, "
                             "%g to %g, is above 0: as depths they are all "
                             "land; set seabed.values ELEVATION",
                             least, greatest);
    }
    if (m->way == PEL_RASTER_BY_SIGN && !depths) {
        if (least < 0 && greatest > 0 && has(m->why, "depth")) {
            return pel_fault_set(
                fault, PEL_ERR_INVALID,
                "\"%.40s\" has numbers above and below 0 and does not say "
                "which way they grow: set seabed.values DEPTH, or say so by "
                "ncatted -a positive,%.40s,o,c,up FILE",
                m->why, m->why);
        }
        down = least >= 0 && greatest > 0;
    }
    *factor = (down ? -1 : 1) * m->metres;
    return PEL_OK;
}

/* --- the unit ------------------------------------------------------------- */

/* "[m]", "Metres." as "m", "metres". */
static bool metres_of(const char *unit, double *out)
{
    char plain[48];
    size_t first = strspn(unit, " [("), length = strlen(unit);
    while (length > first && strchr(" ]).", unit[length - 1])) {
        length--;
    }
    snprintf(plain, sizeof plain, "%.*s", (int)(length - first), unit + first);
    return pel_cf_unit(plain, PEL_CF_M, out);
}

/* The unit that a title has in it: "Elevation (feet)", "depth_fathoms"; 1:
 * none, or metres. */
static double unit_of_words(const struct pel_raster_said *said)
{
    static const char *const units[] = { "ft",        "feet",    "foot",
                                         "fathom",    "fathoms", "cm",
                                         "usft",      "ftus",    "decimeters",
                                         "decimetres" };
    const char *const texts[] = { said->name, said->long_name };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        for (const char *at = texts[i]; *at;) {
            size_t length = strcspn(at, " _-()[],.;:/");
            for (size_t k = 0; k < sizeof units / sizeof *units; k++) {
                double metres = 1;
                if (length == strlen(units[k]) && begins(at, units[k]) &&
                    pel_cf_unit(units[k], PEL_CF_M, &metres)) {
                    return metres;
                }
            }
            at += length + (at[length] != '\0');
        }
    }
    return 1;
}

static enum pel_err find_unit(const struct pel_raster_said *said,
                              OGRSpatialReferenceH srs, double *metres,
                              struct pel_fault *fault)
{
    const char *name = NULL;
    double by_crs = 0;
    OGRAxisOrientation axis;
    if (srs && OSRIsVertical(srs) && OSRGetAxis(srs, "VERT_CS", 0, &axis)) {
        by_crs = OSRGetTargetLinearUnits(srs, "VERT_CS", (char **)&name);
    }
    *metres = by_crs > 0 ? by_crs : unit_of_words(said);
    if (!*said->unit) {
        return PEL_OK;
    }
    if (!metres_of(said->unit, metres)) {
        return pel_fault_set(
            fault, PEL_ERR_INVALID,
            "its unit \"%.40s\" is no length that is known, as m, cm, km, ft, "
            "US survey foot, fathom: give it the right one, as by %s",
            said->unit,
            said->netcdf ? "ncatted -a units,VARIABLE,o,c,m FILE"
                         : "gdal_edit.py -units m FILE");
    }
    if (by_crs > 0 && fabs(*metres / by_crs - 1) > ALIKE) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "its numbers are in \"%.30s\", and its vertical "
                             "CRS is in \"%.30s\": give it the right unit, as "
                             "by gdal_edit.py -units \"%.30s\" FILE",
                             said->unit, name ? name : "?",
                             name ? name : "metre");
    }
    *metres = by_crs > 0 ? by_crs : *metres;
    return PEL_OK;
}

enum pel_err pel_raster_mean(const struct pel_raster_said *said,
                             OGRSpatialReferenceH srs, bool depths,
                             struct pel_raster_meaning *out,
                             struct pel_fault *fault)
{
    *out = (struct pel_raster_meaning){ 1, PEL_RASTER_AS_ASKED, false, "" };
    enum pel_err err = find_unit(said, srs, &out->metres, fault);
    return err ? err : find_way(said, srs, depths, out, fault);
}
