/* The counters of the CIGI bridge for /metrics. Control thread. */
#pragma once

#include "bridges/cigi.h"

struct pel_metrics_page;

/* Writes them as metrics `pelagos_cigi_..._total`. */
void pel_cigi_collect_counters(const struct pel_cigi_counters *counters,
                               struct pel_metrics_page *page);
