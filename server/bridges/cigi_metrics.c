#include "bridges/cigi_metrics.h"

#include <stdio.h>

#include "base/metrics.h"

static void collect_packets(const struct pel_cigi_counters *c,
                            struct pel_metrics_page *page)
{
    char label[96];
    for (int i = 0; i < PEL_CIGI_KIND_COUNT; i++) {
        if (pel_cigi_packets[i].from_host) {
            snprintf(label, sizeof label, "packet=\"%s\"",
                     pel_cigi_packets[i].text);
            pel_metric(page, "pelagos_cigi_packets_total", PEL_METRIC_COUNTER,
                       "CIGI packets taken, by kind.", label,
                       (double)c->packets[i]);
        }
    }
    for (int i = 1; i < PEL_CIGI_ERROR_COUNT; i++) {
        snprintf(label, sizeof label, "reason=\"%s\"",
                 pel_cigi_error_name((enum pel_cigi_error)i));
        pel_metric(page, "pelagos_cigi_malformed_total", PEL_METRIC_COUNTER,
                   "CIGI datagrams that could not be read, by reason.", label,
                   (double)c->malformed[i]);
    }
}

void pel_cigi_collect_counters(const struct pel_cigi_counters *c,
                               struct pel_metrics_page *page)
{
    const struct {
        const char *name, *help;
        uint64_t value;
    } counters[] = {
        { "pelagos_cigi_datagrams_total", "CIGI datagrams taken.",
          c->datagrams },
        { "pelagos_cigi_refused_datagrams_total",
          "CIGI datagrams of a sender not allowed or not leading.",
          c->refused_datagrams },
        { "pelagos_cigi_unknown_packets_total",
          "CIGI packets of an unknown id, skipped.", c->unknown_packets },
        { "pelagos_cigi_skipped_packets_total",
          "CIGI packets without their object, or beyond a limit.",
          c->skipped_packets },
        { "pelagos_cigi_duplicate_total",
          "CIGI datagrams of the newest host frame again, dropped.",
          c->duplicate },
        { "pelagos_cigi_late_total",
          "CIGI datagrams older than the newest, dropped.", c->late },
        { "pelagos_cigi_lost_frames_total",
          "Host frames that had not come when a newer one did.", c->lost },
        { "pelagos_cigi_edits_total", "Changes of the scene by CIGI.",
          c->edits },
        { "pelagos_cigi_refused_edits_total",
          "Changes by CIGI that the scene refused.", c->refused_edits },
        { "pelagos_cigi_frames_total", "Start of Frame datagrams made.",
          c->frames },
        { "pelagos_cigi_skipped_frames_total",
          "Start of Frame datagrams that came too late to be sent.",
          c->skipped_frames },
        { "pelagos_cigi_extrapolated_frames_total",
          "Frames whose time went on without the host.", c->extrapolated },
        { "pelagos_cigi_answers_total", "Answers to CIGI requests.",
          c->answers },
        { "pelagos_cigi_dropped_answers_total",
          "Answers to CIGI requests that found no room.", c->dropped_answers },
        { "pelagos_cigi_unsent_total",
          "Start of Frame datagrams that the system refused.", c->unsent },
    };
    for (size_t i = 0; i < sizeof counters / sizeof *counters; i++) {
        pel_metric(page, counters[i].name, PEL_METRIC_COUNTER, counters[i].help,
                   NULL, (double)counters[i].value);
    }
    collect_packets(c, page);
}
