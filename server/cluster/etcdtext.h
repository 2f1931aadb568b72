/* etcd's messages as JSON. Control thread. */
#pragma once

#include "cluster/etcd.h"

/* What an answer or a line of a watch says. */
struct pel_etcd_text {
    struct pel_etcd_answer answer;
    bool ended;     /* the watch is cancelled */
    bool compacted; /* for it asked for what is not kept any more */
    bool failed;    /* an error, in `why` */
    char why[128];
    char prefix[256]; /* of the path of the pair that is being read */
};
/* MALFORMED: it is no JSON. pel_etcd_text_finish in any case. */
PEL_CHECK enum pel_err pel_etcd_text_read(const char *text, size_t size,
                                          struct pel_etcd_text *out);
void pel_etcd_text_finish(struct pel_etcd_text *text);

/* Bodies; g_free(). */
char *pel_etcd_text_txn(const struct pel_etcd_txn *txn);
char *pel_etcd_text_watch(const char *prefix, uint64_t from_revision);
