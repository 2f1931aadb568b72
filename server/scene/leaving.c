#include "scene/leaving.h"

#include "base/log.h"

size_t pel_leaving_choose(const Pelagos__State *state,
                          const struct pel_snapshot *s, const char *what,
                          size_t most,
                          bool (*does)(const Pelagos__State *,
                                       const struct pel_snapshot *, size_t),
                          size_t *index)
{
    size_t count = 0;
    for (size_t i = 0; i < state->n_entities; i++) {
        if (does(state, s, i)) {
            if (count < most) {
                index[count] = i;
            }
            count++;
        }
    }
    if (count > most) {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "SCN-031",
                        "%zu entities %s; only the first %zu do", count, what,
                        most);
        count = most;
    }
    return count;
}
