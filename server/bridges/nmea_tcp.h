/* NMEA 0183 over TCP: clients send lines, which are treated as those of UDP.
 * The sentences of one read are one edit. Control thread only.
 *
 * A line may arrive in pieces; one longer than a sentence may be is counted and
 * dropped. At most 16 connections; when all are taken, one that was silent for
 * 60 s is closed, else the new one is refused. Nothing is sent. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "base/metrics.h"

struct pel_nmea;
struct pel_nmea_tcp;

struct pel_nmea_tcp_options {
    const char *listen;          /* ADDRESS:PORT */
    const char *allow;           /* as pel_nmea_options */
    struct pel_metrics *metrics; /* NULL: none are shown */
};

/* Listens in the default GMainContext; `nmea` must outlive it. IO, INVALID. */
PEL_CHECK enum pel_err
pel_nmea_tcp_create(const struct pel_nmea_tcp_options *options,
                    struct pel_nmea *nmea, struct pel_nmea_tcp **out,
                    struct pel_fault *fault);
void pel_nmea_tcp_destroy(struct pel_nmea_tcp *tcp); /* NULL allowed */

/* The port bound (useful after port 0). */
uint16_t pel_nmea_tcp_port(const struct pel_nmea_tcp *tcp);
