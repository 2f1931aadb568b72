#include "base/vec.h"
#include "frames/core.h"

const struct pel_snapshot *pel_shown_snapshot(const struct pel_frames *frames)
{
    return frames->sealed.snapshot ? pel_snapshot_ref(frames->sealed.snapshot)
                                   : pel_scene_snapshot(frames->scene);
}

double pel_shown_time(const struct pel_frames *frames)
{
    return frames->sealed.snapshot ? frames->sealed.time_s
                                   : pel_scene_time(frames->scene);
}

double pel_shown_scale(const struct pel_frames *frames)
{
    const struct pel_sealed *sealed = &frames->sealed;
    return sealed->snapshot && sealed->quality > 0 && frames->quality.fixed == 0
               ? pel_clamp(sealed->quality, PEL_QUALITY_MIN, 1)
               : pel_quality_scale(&frames->quality);
}

void pel_frames_show(struct pel_frames *frames, const struct pel_sealed *what)
{
    const struct pel_snapshot *before = frames->sealed.snapshot;
    frames->sealed = *what;
    if (what->snapshot) {
        pel_snapshot_ref(what->snapshot);
        if (frames->subscription_count > 0) {
            pel_live_check(frames, what->snapshot);
        }
        pel_schedule_shown(frames);
    } else {
        pel_schedule_live(frames);
    }
    pel_snapshot_unref(before);
}
