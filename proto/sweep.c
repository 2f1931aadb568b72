#include "sweep.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "message.h"

static bool number(const char *text, double *out)
{
    char *end = NULL;
    *out = g_ascii_strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*out) &&
           strspn(text, "+-.0123456789eE") == strlen(text);
}

/* The numbers between the marks; NULL: something else is there too. */
static double *numbers(const char *text, const char *mark, size_t *count)
{
    g_auto(GStrv) parts = g_strsplit(text, mark, -1);
    size_t n = g_strv_length(parts);
    double *out = malloc((n + 1) * sizeof *out); /* protobuf-c frees it */
    bool right = out != NULL && n > 0;
    for (size_t i = 0; i < n && right; i++) {
        right = number(parts[i], &out[i]);
    }
    if (!right) {
        free(out);
        return NULL;
    }
    *count = n;
    return out;
}

static enum pel_err bad(const char *text, struct pel_fault *fault)
{
    pel_fault_set(fault, PEL_ERR_INVALID,
                  "sweep: `%.60s` is not NAME=FIRST:LAST:STEP "
                  "(sunElevation=0:90:5) nor NAME=VALUE,VALUE "
                  "(wavelength=440,550); axes are parted by ;",
                  text);
    if (fault) {
        snprintf(fault->path, sizeof fault->path, "sweep");
        snprintf(fault->value, sizeof fault->value, "%s", text);
    }
    return PEL_ERR_INVALID;
}

static enum pel_err parse_one(const char *text, Pelagos__SeriesQuery *query,
                              struct pel_fault *fault)
{
    const ProtobufCFieldDescriptor *field =
        protobuf_c_message_descriptor_get_field_by_name(query->base.descriptor,
                                                        "sweep");
    const char *equals = strchr(text, '=');
    if (!equals || equals == text) {
        return bad(text, fault);
    }
    bool range = strchr(equals, ':') != NULL;
    size_t count = 0;
    double *v = numbers(equals + 1, range ? ":" : ",", &count);
    if (!v || (range && count != 2 && count != 3)) {
        free(v);
        return bad(text, fault);
    }
    Pelagos__Sweep *sweep =
        (Pelagos__Sweep *)pel_message_append(&query->base, field);
    g_autofree char *name = g_strndup(text, (gsize)(equals - text));
    pel_message_set_string(&sweep->base,
                           protobuf_c_message_descriptor_get_field_by_name(
                               sweep->base.descriptor, "over"),
                           name);
    if (!range) {
        sweep->values = v;
        sweep->n_values = count;
        return PEL_OK;
    }
    sweep->has_first = sweep->has_last = true;
    sweep->first = v[0];
    sweep->last = v[1];
    sweep->has_step = count == 3;
    sweep->step = count == 3 ? v[2] : 0;
    free(v);
    return PEL_OK;
}

enum pel_err pel_sweep_parse(const char *text, Pelagos__SeriesQuery *query,
                             struct pel_fault *fault)
{
    g_auto(GStrv) parts = g_strsplit(text, ";", -1);
    enum pel_err err = parts[0] ? PEL_OK : bad(text, fault);
    for (char **part = parts; *part && !err; part++) {
        err = parse_one(*part, query, fault);
    }
    return err;
}
