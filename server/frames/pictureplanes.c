#include "frames/pictureplanes.h"

bool pel_picture_planes(const struct pel_picture *picture,
                        struct pel_planes_given *out)
{
    if (picture->ycbcr == PEL_YCBCR_NONE || picture->ycbcr == PEL_YCBCR_CODED) {
        return false;
    }
    *out = (struct pel_planes_given){
        .y = picture->planes[0],
        .u = picture->planes[1],
        .v = picture->planes[2],
        .y_stride = picture->strides[0],
        .u_stride = picture->strides[1],
        .v_stride = picture->strides[2],
        .width = picture->width,
        .height = picture->height,
    };
    return true;
}

const struct pel_jpeg_scan *pel_picture_scan(const struct pel_picture *picture)
{
    return picture->ycbcr == PEL_YCBCR_CODED ? &picture->scan : NULL;
}
