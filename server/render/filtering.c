#include "render/filtering.h"

enum pel_err pel_filtering_settle(const struct pel_filtering *given,
                                  struct pel_filtering *out,
                                  struct pel_fault *fault)
{
    struct pel_filtering f = *given;
    f.n_min = f.n_min == 0 ? PEL_FILTER_DEFAULT.n_min : f.n_min;
    f.n_max = f.n_max == 0 ? PEL_FILTER_DEFAULT.n_max : f.n_max;
    f.cell_px = f.cell_px == 0 ? PEL_CELL_PX_DEFAULT : f.cell_px;
    const struct {
        const char *name;
        double value, least, most;
    } ranges[] = {
        { "the filter's lower bound", f.n_min, 1.0, 4.0 },
        { "the filter's upper bound", f.n_max, 1.0, 8.0 },
        { "the mesh's cell", f.cell_px, 2.0, 64.0 },
    };
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
        if (!(ranges[i].value >= ranges[i].least &&
              ranges[i].value <= ranges[i].most)) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "%s is %g; it must be %g to %g",
                                 ranges[i].name, ranges[i].value,
                                 ranges[i].least, ranges[i].most);
        }
    }
    if (f.n_min >= f.n_max) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "the filter's lower bound is %g; it must be below "
                             "its upper bound, %g",
                             f.n_min, f.n_max);
    }
    *out = f;
    return PEL_OK;
}
