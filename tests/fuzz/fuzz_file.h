/* Files for readers that take a path: the bytes as they are, or a NetCDF file
 * that a text describes, since the form itself is libnetcdf's to read. */
#pragma once

#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <netcdf.h>

#define FUZZ_MOST_CELLS 65536
#define FUZZ_MOST_WORDS 8

static char fuzz_place[64];

static inline void fuzz_remove(void)
{
    unlink(fuzz_place);
}

/* The path of an empty file, always the same one; where there is such a place
 * in memory, since HDF5 opens none without a name. */
static inline const char *fuzz_path(void)
{
    if (!fuzz_place[0]) {
        snprintf(fuzz_place, sizeof fuzz_place, "%s/pelagos-fuzz-XXXXXX",
                 access("/dev/shm", W_OK) ? "/tmp" : "/dev/shm");
        int made = mkstemp(fuzz_place);
        if (made < 0 || close(made) || atexit(fuzz_remove)) {
            abort();
        }
    }
    /* Anew: nc_abort removes it. */
    int fd = open(fuzz_place, O_RDWR | O_CREAT | O_TRUNC, 0600);
    if (fd < 0 || close(fd)) {
        abort();
    }
    return fuzz_place;
}

static inline const char *fuzz_file(const uint8_t *data, size_t size)
{
    const char *path = fuzz_path();
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(data, 1, size, f) != size || fclose(f)) {
        abort();
    }
    return path;
}

static inline int fuzz_words(char *line, char *out[FUZZ_MOST_WORDS])
{
    int count = 0;
    for (char *at = line, *rest; count < FUZZ_MOST_WORDS; at = NULL) {
        char *word = strtok_r(at, " ", &rest);
        if (!word) {
            break;
        }
        out[count++] = word;
    }
    return count;
}

static inline int fuzz_variable(int id, char *const *words, int count)
{
    static const char letters[] = "bcsifd"; /* NC_BYTE .. NC_DOUBLE */
    const char *type = strchr(letters, *words[2]);
    int dims[FUZZ_MOST_WORDS], var = -1, rank = 0;
    double cells = 1;
    for (int i = 3; i < count; i++) {
        size_t length;
        if (nc_inq_dimid(id, words[i], &dims[rank]) ||
            nc_inq_dimlen(id, dims[rank], &length)) {
            return -1;
        }
        cells *= (double)length;
        rank++;
    }
    return type && cells <= FUZZ_MOST_CELLS &&
                   !nc_def_var(id, words[1], (nc_type)(1 + (type - letters)),
                               rank, dims, &var)
               ? var
               : -1;
}

/* `d NAME LENGTH`, `v NAME TYPE DIM…`, `a NAME text` of the last variable (of
 * numbers where it begins with #). */
static inline void fuzz_define(int id, char *line, int *var)
{
    char *words[FUZZ_MOST_WORDS];
    int dim;
    if (line[0] == 'a') {
        char *name = strtok_r(line + 1, " ", &line);
        if (name && *line == '#') {
            double value = strtod(line + 1, NULL);
            (void)nc_put_att_double(id, *var < 0 ? NC_GLOBAL : *var, name,
                                    NC_DOUBLE, 1, &value);
        } else if (name) {
            (void)nc_put_att_text(id, *var < 0 ? NC_GLOBAL : *var, name,
                                  strlen(line), line);
        }
        return;
    }
    int count = fuzz_words(line, words);
    if (count == 3 && *words[0] == 'd') {
        (void)nc_def_dim(id, words[1], strtoul(words[2], NULL, 10) % 4096,
                         &dim);
    } else if (count >= 3 && *words[0] == 'v') {
        *var = fuzz_variable(id, words, count);
    }
}

/* `= NAME value…`, again and again until the variable is full; of text: the
 * text. */
static inline void fuzz_values(int id, char *line)
{
    static double values[FUZZ_MOST_CELLS];
    static char text[FUZZ_MOST_CELLS];
    char *rest, *name = strtok_r(line + 1, " ", &rest);
    int var, rank, dims[NC_MAX_VAR_DIMS];
    nc_type type;
    size_t cells = 1, count = 0, length, letters = name ? strlen(rest) : 0;
    if (!name || nc_inq_varid(id, name, &var) ||
        nc_inq_var(id, var, NULL, &type, &rank, dims, NULL)) {
        return;
    }
    for (int i = 0; i < rank; i++) {
        cells *= nc_inq_dimlen(id, dims[i], &length) ? 0 : length;
    }
    if (cells > FUZZ_MOST_CELLS) {
        return;
    }
    for (size_t i = 0; type == NC_CHAR && letters > 0 && i < cells; i++) {
        text[i] = rest[i % letters];
    }
    for (char *end; type != NC_CHAR && count < cells; rest = end) {
        values[count] = strtod(rest, &end);
        if (end == rest) {
            break;
        }
        count++;
    }
    for (size_t i = count; count > 0 && i < cells; i++) {
        values[i] = values[i % count];
    }
    (void)(type == NC_CHAR ? nc_put_var_text(id, var, text)
           : count > 0     ? nc_put_var_double(id, var, values)
                           : 0);
}

/* NULL: it cannot be. */
static inline const char *fuzz_netcdf(const uint8_t *data, size_t size,
                                      int mode)
{
    const char *path = fuzz_path();
    int id, var = -1;
    if (nc_create(path, mode, &id)) {
        return NULL;
    }
    for (int pass = 0; pass < 2; pass++) {
        char *text = strndup((const char *)data, size), *rest;
        if (!text) {
            abort();
        }
        for (char *line = strtok_r(text, "\n", &rest); line;
             line = strtok_r(NULL, "\n", &rest)) {
            if (*line == '=' && pass == 1) {
                fuzz_values(id, line);
            } else if (*line && *line != '=' && pass == 0) {
                fuzz_define(id, line, &var);
            }
        }
        free(text);
        if (pass == 0 && nc_enddef(id)) {
            (void)nc_abort(id);
            return NULL;
        }
    }
    return nc_close(id) ? NULL : path;
}
