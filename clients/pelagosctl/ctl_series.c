/* --sweep: one question at many values, by pelagosd, as a table or a file. */
#include "pelagosctl/ctl.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <glib.h>

#include "json.h"
#include "sweep.h"

static const struct {
    const char *word, *ending;
    Pelagos__SeriesFormat format;
} formats[] = {
    { "csv", ".csv", PELAGOS__SERIES_FORMAT__CSV },
    { "json", ".json", PELAGOS__SERIES_FORMAT__LISTS },
    { "netcdf", ".nc", PELAGOS__SERIES_FORMAT__NETCDF },
};

static enum ctl_exit read_format(const struct ctl *ctl,
                                 Pelagos__SeriesQuery *query)
{
    const char *word = ctl_value(ctl, "format");
    const char *file = ctl_value(ctl, "output");
    query->has_format = true;
    query->format = ctl_flag(ctl, "json") ? PELAGOS__SERIES_FORMAT__LISTS
                                          : PELAGOS__SERIES_FORMAT__CSV;
    for (size_t i = 0; i < G_N_ELEMENTS(formats); i++) {
        if (word ? g_ascii_strcasecmp(word, formats[i].word) == 0
                 : file && g_str_has_suffix(file, formats[i].ending)) {
            query->format = formats[i].format;
            return query->format == PELAGOS__SERIES_FORMAT__NETCDF && !file &&
                           isatty(STDOUT_FILENO)
                       ? ctl_say(CTL_USAGE, "NetCDF is not for terminals: give "
                                            "--output FILE")
                       : CTL_DONE;
        }
    }
    if (word) {
        return ctl_say(CTL_USAGE,
                       "--format %s: one of csv, json, netcdf is "
                       "wanted",
                       word);
    }
    return file && !ctl_flag(ctl, "json")
               ? ctl_say(CTL_USAGE,
                         "--output %s: a file that ends in .csv, .json or .nc "
                         "is wanted, or --format too",
                         file)
               : CTL_DONE;
}

enum ctl_exit ctl_put(const char *file, const void *data, size_t size)
{
    FILE *out = file ? fopen(file, "wb") : stdout;
    bool whole = out && fwrite(data, 1, size, out) == size;
    whole = out && (file ? fclose(out) : fflush(out)) == 0 && whole;
    return whole ? CTL_DONE
                 : ctl_say(CTL_FAILED, "%s: %s", file ? file : "output",
                           strerror(errno));
}

bool ctl_wants_series(const struct ctl *ctl)
{
    return ctl_flag(ctl, "sweep") || ctl_flag(ctl, "format") ||
           ctl_flag(ctl, "output");
}

enum ctl_exit ctl_series(struct ctl *ctl, Pelagos__SeriesQuery *query)
{
    struct pel_fault fault;
    struct pel_client_error error;
    Pelagos__Series *series = NULL;
    enum ctl_exit status = read_format(ctl, query);
    const char *sweep = ctl_value(ctl, "sweep");
    if (status == CTL_DONE && sweep && pel_sweep_parse(sweep, query, &fault)) {
        status = ctl_say(CTL_USAGE, "%s", fault.message);
    }
    if (status == CTL_DONE &&
        pel_client_series(ctl->client, query, &series, &error)) {
        status = ctl_report(ctl, &error);
    }
    if (series) {
        bool is_file = query->format != PELAGOS__SERIES_FORMAT__LISTS;
        char *text =
            is_file ? NULL : pel_json_from_message(&series->base, true);
        status = text ? ctl_put(ctl_value(ctl, "output"), text, strlen(text))
                      : ctl_put(ctl_value(ctl, "output"), series->file.data,
                                series->file.len);
        free(text);
        pelagos__series__free_unpacked(series, NULL);
    }
    for (size_t i = 0; i < query->n_sweep; i++) {
        pelagos__sweep__free_unpacked(query->sweep[i], NULL);
    }
    free(query->sweep);
    query->sweep = NULL;
    query->n_sweep = 0;
    return status;
}
