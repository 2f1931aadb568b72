#!/bin/bash
# The encoders' files, read by programs that are not ours: djpeg or ffmpeg,
# exrheader. Argument: the encode_test program.
set -eu
test_program=${1:-${PELAGOS_BIN:-build/release/bin}/encode_test}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
PEL_SAMPLES=$folder "$test_program" >/dev/null 2>&1

size() {
    ffprobe -v error -select_streams v -of csv=p=0 \
        -show_entries stream=codec_name,width,height,pix_fmt "$folder/$1"
}
expect() {
    if [ "$2" != "$3" ]; then
        echo "not ok - $1: got '$2', wanted '$3'"
        exit 1
    fi
    echo "ok - $1"
}
expect 'ffprobe reads the JPEG' "$(size odd.jpg)" mjpeg,131,77,yuvj420p
expect 'ffprobe reads the PNG' "$(size odd.png)" png,131,77,rgb24
header=$(exrheader "$folder/half.exr")
for line in 'R, 16-bit floating-point, sampling 1 1' \
    'depth.Z, 32-bit floating-point, sampling 1 1' \
    'pelagos.view (type string): "bridge"' \
    'compression (type compression): zip, multi-scanline blocks'; do
    grep -qF "$line" <<<"$header" || { echo "not ok - exrheader: $line"; exit 1; }
    echo "ok - exrheader: $line"
done
# Red of the last pixel of the float file, through ffmpeg's own EXR reader:
# i = 131*77 - 1 = 10086 is 2^(10086 % 46 - 28) (1 + (10086 % 97)/97).
red=$(ffmpeg -v error -i "$folder/float.exr" -f rawvideo -pix_fmt gbrpf32le - |
    /usr/bin/python3 -c '
import numpy, sys
p = numpy.frombuffer(sys.stdin.buffer.read(), "<f4").reshape(3, 77, 131)
want = numpy.ldexp(numpy.float32(1 + 10086 % 97 / 97), 10086 % 46 - 28)
print(abs(p[2, 76, 130] / want - 1) < 1e-6)')
expect 'ffmpeg reads the float EXR' "$red" True
# EXIF and XMP of what the encoders write, by exiftool.
for kind in jpg png; do
    notes=$(exiftool -n -s -s -s -p \
        '$IFD0:ImageDescription|$ExifIFD:SubSecTimeOriginal|$GPS:GPSLatitudeRef|$GPS:GPSImgDirection|$GPS:GPSAltitude|$XMP-pelagos:Roll' \
        "$folder/photo.$kind")
    expect "exiftool reads the $kind" "$notes" 'bridge <&">|25|S|270.13|18.5|1.250000'
    expect "exiftool finds nothing wrong with the $kind" \
        "$(exiftool -s -warning -error "$folder/photo.$kind")" ''
    place=$(exiftool -n -p '$GPSLatitude $GPSLongitude' "$folder/photo.$kind")
    expect "the place of the $kind" \
        "$(awk '{printf "%.7f %.7f", $1, $2}' <<<"$place")" '-33.5125000 151.2500125'
done
