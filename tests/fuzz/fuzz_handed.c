/* What the processes that read files hand over: bytes → what the daemon makes
 * of them, which must answer everywhere and always. pel_helper_run is this
 * file's own: it gives the input for the reader's answer. The first byte says
 * whose it is, a second one whether the magic bytes are put in front. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/helper.h"
#include "base/vec.h"
#include "continents/continents.h"
#include "models/modelload.h"
#include "ocean/spectrumfile.h"
#include "panorama/panorama.h"
#include "seabed/load.h"
#include "seabed/wire.h"
#include "weather/load.h"
#include "weather/wire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const uint8_t *handed;
static size_t handed_size;
static const char *magic;  /* NULL: none in front */
static const char *folder; /* NULL: none is configured */
static const char *subject;

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

enum pel_err pel_helper_find(const char *directory, const char *file,
                             struct pel_fault *fault)
{
    (void)directory;
    (void)file;
    (void)fault;
    return PEL_OK;
}

enum pel_err pel_helper_run(const struct pel_helper_task *task,
                            unsigned char **out, size_t *size,
                            struct pel_fault *fault)
{
    size_t head = magic ? strlen(magic) : 0;
    *out = NULL;
    if (handed_size + head > task->most_bytes) {
        return pel_fault_set(fault, PEL_ERR_INVALID, "too many bytes");
    }
    *size = handed_size + head;
    *out = malloc(*size + 1);
    demand(*out != NULL);
    if (head > 0) {
        memcpy(*out, magic, head);
    }
    memcpy(*out + head, handed, handed_size);
    return PEL_OK;
}

/* --- what is made of it --------------------------------------------------- */

static void look_at_weather(const struct pel_weather *w)
{
    double span = w->unix_s[w->times - 1] - w->unix_s[0];
    for (int i = -3; i < 14; i++) {
        struct pel_weather_now now;
        pel_weather_at(w, (15 * i - 90) * PEL_DEG,
                       (w->west_deg + 41 * i) * PEL_DEG,
                       w->unix_s[0] + span * i / 9.3, &now);
        demand(hypot(now.wind_east_mps, now.wind_north_mps) < 182 &&
               now.height_m <= 32 && fabs(now.period_s) <= 32 &&
               fabs(now.direction_rad) <= PEL_PI && now.agreement >= 0 &&
               now.agreement <= 1 && now.wind_height_m <= 32 &&
               fabs(now.swell_period_s) <= 32);
    }
}

static void weather(struct pel_fault *fault)
{
    const struct pel_weather *w = NULL;
    if (!pel_weather_load(folder, subject, &w, fault)) {
        look_at_weather(w);
        pel_weather_unref(w);
    }
}

static void look_at_seabed(const struct pel_seabed *bed)
{
    double width = bed->columns * bed->spacing_m;
    for (int i = -2; i < 12; i++) {
        double h = 0, east = bed->west_m + width * i / 9.7,
               north = bed->south_m + bed->rows * bed->spacing_m * i / 8.3;
        bool known = pel_seabed_height(bed, east, north, &h);
        double drawn = pel_seabed_drawn(bed, east, north, -1);
        demand(isfinite(h) && isfinite(drawn) && (!known || drawn == h) &&
               h >= PEL_SEABED_LOWEST && h <= PEL_SEABED_HIGHEST);
    }
}

static void seabed(struct pel_fault *fault)
{
    const struct pel_seabed_source source = { .directory = folder,
                                              .file = subject,
                                              .offset_m =
                                                  handed_size % 2 ? 0.5 : 0,
                                              .placed = handed_size % 3 };
    const struct pel_seabed *bed = NULL;
    if (!pel_seabed_load(&source, &bed, fault)) {
        look_at_seabed(bed);
        pel_seabed_unref(bed);
    }
}

static void panorama(struct pel_fault *fault)
{
    const struct pel_panorama *p = NULL;
    if (!pel_panorama_load(folder, subject, handed_size % 8 == 0, &p, fault)) {
        demand(p->columns == 2 * p->rows && isfinite(p->unit) && p->unit > 0);
        demand(!p->has_sun ||
               (isfinite(p->sun[0]) && p->sun_elevation_rad >= 0));
        for (int i = 0; i < 3 * p->columns * p->rows; i++) {
            demand(p->halves[i] < 0x7c00); /* finite, not negative */
        }
        pel_panorama_unref(p);
    }
}

static void spectrum(struct pel_fault *fault)
{
    static struct pel_measured m;
    double unix_s = 0;
    if (!pel_spectrum_file_read("/spectra", "a.nc", "", NAN, &m, &unix_s,
                                fault)) {
        demand(isfinite(unix_s) && m.count >= 3 &&
               m.count <= PEL_MEASURED_MOST && m.frequency_hz[0] > 0);
    }
}

/* Written as its reader would, it is read again. */
static void look_at_model(const struct pel_model *m)
{
    char *bytes = NULL, notes[PEL_MODEL_NOTES];
    size_t size = 0;
    struct pel_model_draft draft;
    FILE *to = open_memstream(&bytes, &size);
    demand(to && pel_model_wire_write(to, m, "notes") && fclose(to) == 0);
    demand(!pel_model_wire_read((unsigned char *)bytes, size, &draft, notes,
                                NULL));
    demand(draft.model.index_count == m->index_count);
    pel_model_draft_clear(&draft);
    free(bytes);
    for (int i = 0; i < 16; i++) {
        struct pel_model_hit hit;
        double z, x = m->low.x + (m->high.x - m->low.x) * (i % 4) / 3.1;
        double y = m->low.y + (m->high.y - m->low.y) * (i / 4) / 3.3;
        demand(!pel_model_top(m, x, y, &hit, &z) ||
               (hit.node < m->node_count && hit.material < m->material_count));
    }
    demand(pel_model_level_for(m, 1, 1) < m->level_count);
}

static void model(struct pel_fault *fault)
{
    const struct pel_model_source source = { .directory = folder,
                                             .file = subject,
                                             .length_m =
                                                 handed_size % 2 ? 30 : 0,
                                             .beam_m =
                                                 handed_size % 3 ? 9 : 0 };
    const struct pel_model *m = NULL;
    char notes[PEL_MODEL_NOTES];
    if (!pel_model_load(&source, &m, notes, fault)) {
        demand(isfinite(m->length_m) && isfinite(m->beam_m) &&
               memchr(notes, 0, sizeof notes));
        look_at_model(m);
        pel_model_unref(m);
    }
}

/* Of the one size there is, or not at all: an empty input is filled. */
static void continents(struct pel_fault *fault)
{
    static unsigned char *whole;
    struct pel_continents *c = NULL;
    if (handed_size == 3 && memcmp(handed, "get", 3) == 0) {
        demand(pel_continents_get() == pel_continents_get());
    }
    if (handed_size == 4 && memcmp(handed, "fill", 4) == 0) {
        whole = whole ? whole : calloc(1, PEL_CONTINENT_BYTES);
        demand(whole != NULL);
        handed = whole;
        handed_size = PEL_CONTINENT_BYTES - (magic ? strlen(magic) : 0);
    }
    if (!pel_continents_load("/land", "binned_GSHHS_l.nc", &c, fault)) {
        demand(c->share && c->ground);
        pel_continents_free(c);
    }
}

/* With a description of a few of its words. */
static const char *described(void)
{
    static const char text[] =
        "{\"class\": \"CARGO\", \"length\": 40, "
        "\"eyes\": [{\"name\": \"bridge\", \"up\": 9}], "
        "\"lights\": [{\"name\": \"mast\", \"up\": 12}]}";
    static char path[] = "/dev/shm/pelagos-fuzz-XXXXXX";
    static bool made;
    char name[80];
    if (!made) {
        demand(mkdtemp(path) != NULL);
        snprintf(name, sizeof name, "%s/a.json", path);
        FILE *f = fopen(name, "w");
        demand(f && fputs(text, f) >= 0 && fclose(f) == 0);
        made = true;
    }
    return path;
}

static const struct {
    const char *magic;
    void (*take)(struct pel_fault *fault);
} readers[] = {
    { PEL_SEABED_WIRE_MAGIC, seabed }, { PEL_WEATHER_WIRE_MAGIC, weather },
    { PEL_PANORAMA_MAGIC, panorama },  { PEL_SPECTRUM_FILE_MAGIC, spectrum },
    { PEL_MODEL_WIRE_MAGIC, model },   { PEL_CONTINENT_MAGIC, continents },
};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pel_fault fault = { 0 };
    if (size < 2) {
        return 0;
    }
    size_t reader = data[0] % (sizeof readers / sizeof *readers);
    magic = data[1] % 2 ? readers[reader].magic : NULL;
    unsigned place = data[1] / 2 % 4;
    folder = place == 1 ? NULL : place == 3 ? described() : "/nowhere";
    subject = place == 2 ? "../a.tif" : "a.glb";
    handed = data + 2;
    handed_size = size - 2;
    readers[reader].take(&fault);
    return 0;
}
