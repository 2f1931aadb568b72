/* A start that is only tried (pelagosd --check): each part is made as for a
 * start and destroyed, but nothing listens, nothing is sent, and no file
 * changes. Control thread. */
#pragma once

#include <stdbool.h>
#include <sys/socket.h>

#include "base/err.h"

void pel_trial_begin(void); /* before the first part is made */
bool pel_trial(void);

/* On standard output: what a start would not refuse, but who tries wants to
 * know. */
void pel_trial_note(const char *format, ...)
    __attribute__((format(printf, 1, 2)));

/* Whether a socket of that type could listen there: the address is this
 * machine's, the port may be had by this user, and no option that was tried
 * before has it (CONFLICT names both). That another process listens there now
 * is a note. option: "http". */
PEL_CHECK enum pel_err pel_trial_listen(const char *option, int type,
                                        const struct sockaddr *address,
                                        socklen_t size,
                                        struct pel_fault *fault);

/* Whether this user may make or write a file there: IO says why not. */
PEL_CHECK enum pel_err pel_trial_write(const char *option, const char *path,
                                       struct pel_fault *fault);
