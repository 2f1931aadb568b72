/* Metrics: every room counts for itself and says so when asked; /metrics shows
 * them all in Prometheus' text format 0.0.4. Control thread only. */
#pragma once

#include <stddef.h>

enum pel_metric_type {
    PEL_METRIC_COUNTER, /* only grows; the name ends in _total */
    PEL_METRIC_GAUGE,
    PEL_METRIC_SUMMARY, /* samples with the label `quantile` */
};

struct pel_metrics_page;

/* Adds one sample. `name` is [a-z_]+ with base units (`_seconds`, `_bytes`);
 * `help` a sentence; `labels` what stands between the braces, for example
 * `input="nmea"`, or NULL. Samples of one name may come from several rooms:
 * the first one's help and type count. The strings are copied. */
void pel_metric(struct pel_metrics_page *page, const char *name,
                enum pel_metric_type type, const char *help, const char *labels,
                double value);

/* Writes a room's samples with pel_metric. */
typedef void (*pel_metrics_collect)(void *user, struct pel_metrics_page *page);

struct pel_metrics;
struct pel_metrics *pel_metrics_create(void);
void pel_metrics_destroy(struct pel_metrics *metrics); /* NULL allowed */

/* Registers a room, at most 32; `remove` takes the same pair. */
void pel_metrics_add(struct pel_metrics *metrics, pel_metrics_collect collect,
                     void *user);
void pel_metrics_remove(struct pel_metrics *metrics,
                        pel_metrics_collect collect, void *user);

/* The whole page, sorted by name; free() it. *size may be NULL. */
char *pel_metrics_text(struct pel_metrics *metrics, size_t *size);
