#!/usr/bin/env bash
# Draws the gallery: docs/gallery/make.sh [FOLDER [NAME…]], those pictures
# alone or all. Each is one `pelagosctl set` on a common scene and one `pelagosctl
# frame`; the same commands are listed in README.md beside the pictures, which
# this writes too.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=${1:-docs/gallery}
only=" ${*:2} "
socket=$(mktemp -u "${TMPDIR:-/tmp}/pelagos-gallery-XXXXXX")
mkdir -p build/gallery
for depth in 7.9 39.9; do
    docs/gallery/shore.py "build/gallery/shore-$depth.asc" "$depth"
done
docs/gallery/weather.py build/gallery/pacific.nc
build/pelagosd --device software --http off --tcp off --rtsp off --modbus off --nmea off \
    --state off --bathymetry build/gallery --weather build/gallery --unix "$socket" --log-level warning &
daemon=$!
trap 'kill $daemon 2>/dev/null; wait $daemon 2>/dev/null || true' EXIT
ctl() { build/pelagosctl --quiet --timeout 60 --server "unix:$socket" "$@"; }
for _ in $(seq 100); do
    [ -S "$socket" ] && break
    sleep 0.1
done

common="clock.mode=STEPPED clock.time=100 sea.windDirection=250 sea.windSpeed=8 \
sky.sunElevation=35 sky.sunAzimuth=55 sky.visibility=40000 views.gallery.up=6 \
views.gallery.pitch=-5 views.gallery.yaw=0 views.gallery.right=0 views.gallery.forward=0 \
views.gallery.width=640 views.gallery.height=360"
lagoon="sea.windSpeed=4 views.gallery.up=10 views.gallery.pitch=-16 sky.sunAzimuth=110"
open="sea.windSpeed=4 views.gallery.up=10 views.gallery.pitch=-16 sky.sunAzimuth=110 sky.sunElevation=55 water.jerlov=IB"
slick="sea.spectrum=ELFOUHAILY sea.windSpeed=6 sky.sunAzimuth=10 sea.areas.0.north=190 \
sea.areas.0.factor=0.3 sea.areas.0.edge=25 \
sea.areas.0.corners=-420:-60,-180:-20,-40:-70,130:-40,300:-90,330:-30,180:40,30:30,-120:80,-300:40 \
sea.areas.1.east=110 sea.areas.1.north=330 sea.areas.1.radius=60 sea.areas.1.factor=1.4 sea.areas.1.edge=50"
shore="sea.windSpeed=3 sky.sunElevation=50 sky.sunAzimuth=200 views.gallery.up=9 \
views.gallery.pitch=-11 views.gallery.yaw=35 water.named=TROPICAL water.bottom=SAND"
ship="sea.synthesiser=FFT sea.spectrum=ELFOUHAILY entities.2.longitude=5.2 entities.2.afloat=true"
# One path from the water to space.
climb="origin.latitude=38 origin.longitude=-32 sea.windSpeed=7 sky.sunElevation=42 sky.sunAzimuth=62 sky.visibility=80000 views.gallery.yaw=40"
under="sea.synthesiser=FFT sea.windSpeed=5 sky.sunElevation=60 sky.sunAzimuth=0 views.gallery.fieldOfView=90"
pictures=(
    "ship-yacht|A yacht in the evening, 7 m/s|$ship sea.windSpeed=7 views.gallery.up=5 views.gallery.pitch=-2 sky.sunElevation=9 sky.sunAzimuth=352 entities.2.model.name=sailing-yacht entities.2.latitude=52.6007 entities.2.longitude=5.2001 entities.2.heading=300"
    "ship-container|A container ship 400 m ahead, 12 m/s|$ship sea.windSpeed=12 sea.windDirection=200 views.gallery.up=14 views.gallery.pitch=-2 sky.sunElevation=24 sky.sunAzimuth=310 entities.2.model.name=container-ship entities.2.latitude=52.6037 entities.2.heading=235"
    "ship-tanker|A tanker 550 m ahead, 22 m/s|$ship sea.windSpeed=22 views.gallery.up=18 views.gallery.pitch=-4 sky.sunElevation=30 sky.sunAzimuth=250 entities.2.model.name=tanker entities.2.latitude=52.605 entities.2.heading=60"
    "ship-buoy|A cardinal buoy, north, 8 m/s|$ship views.gallery.up=4 views.gallery.pitch=-3 sky.sunElevation=40 sky.sunAzimuth=160 entities.2.model.name=cardinal-north entities.2.latitude=52.6003 entities.2.longitude=5.2001 entities.2.heading=0"
    "calm|Calm: wind 1.5 m/s|sea.windSpeed=1.5"
    "wind-05|Wind 5 m/s|sea.windSpeed=5"
    "wind-10|Wind 10 m/s|sea.windSpeed=10"
    "wind-15|Wind 15 m/s, from a bridge at 15 m|sea.windSpeed=15 views.gallery.up=15"
    "wind-20|Wind 20 m/s, from a bridge at 15 m|sea.windSpeed=20 views.gallery.up=15"
    "sun-noon|Noon, the Sun behind|sky.sunElevation=61 sky.sunAzimuth=180"
    "sun-10|Sun 10° above the horizon|sky.sunElevation=10 sky.sunAzimuth=12"
    "sun-02|Sun 2° above the horizon|sky.sunElevation=2 sky.sunAzimuth=12"
    "sun-dusk|Dusk: Sun 5° below the horizon|sky.sunElevation=-5 sky.sunAzimuth=12"
    "night-moon|Night: a Moon 20° above the horizon, 97 % lit|sky.sunElevation=-30 sky.moonElevation=20 sky.moonAzimuth=10 sky.moonPhase=0.97 views.gallery.pitch=3"
    "night-stars|A moonless night, as a long exposure has it|clock.utc=2026-08-12T22:00:00Z sky.sunElevation=-30 views.gallery.yaw=190 views.gallery.pitch=14 views.gallery.fieldOfView=75 views.gallery.exposure=-7 sea.windSpeed=4"
    "fog-bank|A tanker half in a fog bank, Sun 7° above the horizon|sea.synthesiser=FFT sky.sunElevation=7 sky.sunAzimuth=32 entities.2.model.name=tanker entities.2.latitude=52.6063 entities.2.longitude=5.202 entities.2.heading=72 sea.windSpeed=4 sea.windDirection=80 views.gallery.up=14 views.gallery.pitch=0.5 views.gallery.yaw=10 views.gallery.fieldOfView=40 sky.fog.0.visibility=140 sky.fog.0.top=34 sky.fog.0.radius=420 sky.fog.0.latitude=52.6058 sky.fog.0.longitude=5.2065 sky.fog.0.speed=0 sky.fog.1.visibility=9000 sky.fog.1.top=60"
    "ship-evening|A yacht in the evening under three octas of cumulus, 8 m/s|sea.synthesiser=FFT sea.spectrum=ELFOUHAILY entities.2.longitude=5.2001 entities.2.afloat=true sea.windSpeed=8 views.gallery.up=5 views.gallery.pitch=4 sky.sunElevation=11 sky.sunAzimuth=30 entities.2.model.name=sailing-yacht entities.2.latitude=52.60045 entities.2.heading=300 sky.cloudCover=3 views.gallery.width=960 views.gallery.height=540"
    "night-lamps|A container ship at anchor, the Sun 10° below the horizon, as an eye sees it|sea.synthesiser=FFT sea.spectrum=ELFOUHAILY sea.windSpeed=6 entities.2.model.name=container-ship entities.2.afloat=true entities.2.latitude=52.6045 entities.2.longitude=5.1995 entities.2.heading=300 entities.2.lights=AUTO entities.2.navigationStatus=AT_ANCHOR sky.sunElevation=-10 sky.sunAzimuth=340 sky.visibility=30000 views.gallery.vision=EYE views.gallery.up=10 views.gallery.pitch=-2 views.gallery.fieldOfView=50"
    "clouds-heaps|Four octas of cumulus, 9 m/s|sea.synthesiser=FFT sea.windSpeed=9 sky.cloudCover=4 sky.sunElevation=38 sky.sunAzimuth=130 views.gallery.pitch=5 views.gallery.up=12"
    "clouds-evening|An evening: six octas of altocumulus, 8 m/s|sea.synthesiser=FFT sky.cloudCover=6 sky.cloudGenus=ALTOCUMULUS sky.sunElevation=7 sky.sunAzimuth=25 views.gallery.pitch=6 views.gallery.up=12"
    "clouds-storm|A storm, 24 m/s: overcast, nimbostratus|sea.synthesiser=FFT sea.windSpeed=24 sky.cloudCover=8 sky.cloudGenus=NIMBOSTRATUS sky.sunElevation=30 sky.visibility=12000 views.gallery.pitch=-4 views.gallery.up=15"
    "height-4|From 4 m|views.gallery.up=4"
    "height-30|From 30 m|views.gallery.up=30 views.gallery.pitch=-8"
    "height-1000|From 1000 m|views.gallery.up=1000 views.gallery.pitch=-18 sky.sunAzimuth=30"
    "height-8000|From 8000 m|views.gallery.up=8000 views.gallery.pitch=-18 sky.sunAzimuth=30"
    "climb-2|A climb into space: from 2 m|$climb views.gallery.up=2 views.gallery.pitch=-2"
    "climb-100|From 100 m|$climb views.gallery.up=100 views.gallery.pitch=-9"
    "climb-1000|From 1 km|$climb views.gallery.up=1000 views.gallery.pitch=-12"
    "climb-10000|From 10 km: the ellipsoid begins to replace the sphere, and each point's own light its nadir's|$climb views.gallery.up=10000 views.gallery.pitch=-14"
    "climb-20000|From 20 km, three octas of cumulus|$climb views.gallery.up=20000 views.gallery.pitch=-16 sky.cloudCover=3"
    "climb-50000|From 50 km, three octas|$climb origin.latitude=30 views.gallery.up=50000 views.gallery.pitch=-16 sky.cloudCover=3"
    "space-400|From 400 km, over the Mediterranean|origin.latitude=38.5 origin.longitude=12 sky.visibility=80000 sky.sunElevation=50 sky.sunAzimuth=150 sky.cloudCover=4 views.gallery.up=400000 views.gallery.pitch=-30 views.gallery.yaw=100 views.gallery.fieldOfView=70"
    "space-400-sunset|From 400 km: the glitter of a low Sun and the limb|origin.latitude=20 origin.longitude=-150 sky.visibility=80000 sky.sunElevation=12 sky.sunAzimuth=40 views.gallery.up=400000 views.gallery.pitch=-19 views.gallery.yaw=40 views.gallery.fieldOfView=60 sky.cloudCover=4"
    "space-earth|The Earth from 10,000 km: day, terminator, night|origin.latitude=18 origin.longitude=-15 sky.visibility=80000 sky.sunElevation=35 sky.sunAzimuth=250 sky.cloudCover=4 views.gallery.up=10000000 views.gallery.pitch=-90 views.gallery.yaw=0 views.gallery.fieldOfView=52 views.gallery.height=640"
    "space-weather|From 5,000 km: winds by a weather field, a storm with its calm eye in the Sun's glitter|origin.latitude=18 origin.longitude=-152 sea.synthesiser=FFT sea.spectrum=ELFOUHAILY sea.field.file=pacific.nc sea.field.leads=false sky.visibility=80000 sky.sunElevation=62 sky.sunAzimuth=150 views.gallery.up=5000000 views.gallery.pitch=-90 views.gallery.fieldOfView=56 views.gallery.height=480"
    "fft|FFT cascades, Elfouhaily, wind 12 m/s, from 9 m|sea.synthesiser=FFT sea.spectrum=ELFOUHAILY sea.windSpeed=12 views.gallery.up=9"
    "fft-glitter|The same into the Sun|sea.synthesiser=FFT sea.spectrum=ELFOUHAILY sea.windSpeed=7 sky.sunElevation=25 sky.sunAzimuth=10"
    "slick-30|A slick in the glitter, a gust behind it, from 30 m|$slick sky.sunElevation=25 views.gallery.up=30 views.gallery.pitch=-8"
    "slick-500|The same from 500 m|$slick sky.sunElevation=50 views.gallery.up=500 views.gallery.forward=-280 views.gallery.pitch=-42"
    "fog|Visibility 1500 m|sky.visibility=1500"
    "squall|A squall: 40 mm/h of rain, 16 m/s, by 1/250 s|sea.synthesiser=FFT sea.spectrum=ELFOUHAILY sea.windSpeed=16 sky.rain=40 sky.cloudCover=8 sky.cloudGenus=NIMBOSTRATUS sky.visibility=20000 views.gallery.up=9 views.gallery.yaw=215 views.gallery.shutter=0.004"
    "snow|Snow, 2 mm/h of water, 7 m/s|sea.synthesiser=FFT sea.spectrum=ELFOUHAILY sea.windSpeed=7 sky.snow=2 sky.cloudCover=8 sky.cloudGenus=NIMBOSTRATUS sky.visibility=20000 views.gallery.up=9 views.gallery.yaw=215"
    "lens|Drops on the lens|sea.synthesiser=FFT sea.spectrum=ELFOUHAILY sea.windSpeed=10 sky.rain=5 sky.cloudCover=8 sky.cloudGenus=NIMBOSTRATUS sky.visibility=20000 views.gallery.up=9 views.gallery.wetLens=0.6"
    "swell|Swell of 3 m, 12 s under a light wind|sea.windSpeed=3 sea.swell.0.height=3 sea.swell.0.period=12 sea.swell.0.direction=320 views.gallery.up=12"
    "water-single|Fig. 9 of the 2003 paper: single scattering|$open water.orders=SINGLE"
    "water-multiple|Fig. 9: every order|$open"
    "water-tropical|Fig. 10: tropical noon|$lagoon sky.sunElevation=61 water.named=TROPICAL water.bottom=SAND water.depth=6"
    "water-sunset|Fig. 10: tropical sunset|$lagoon sky.sunElevation=3 sky.sunAzimuth=40 water.named=TROPICAL water.bottom=SAND water.depth=6"
    "water-dusk|The same under the sky alone, Sun 4° below the horizon|$lagoon sky.sunElevation=-4 sky.sunAzimuth=40 water.named=TROPICAL water.bottom=SAND water.depth=6"
    "water-8m|7.9 m of tropical water over sand|$lagoon water.named=TROPICAL water.bottom=SAND water.depth=7.9"
    "water-40m|39.9 m of it|$lagoon water.named=TROPICAL water.bottom=SAND water.depth=39.9"
    "shore-8m|A shore, 7.9 m deep (fig. 11 of the 2003 paper)|$shore water.depth=7.9 seabed.file=shore-7.9.asc"
    "shore-8m-single|The same by single scattering|$shore water.depth=7.9 seabed.file=shore-7.9.asc water.orders=SINGLE"
    "shore-40m|The shore, 39.9 m deep|$shore water.depth=39.9 seabed.file=shore-39.9.asc"
    "shore-40m-single|The same by single scattering|$shore water.depth=39.9 seabed.file=shore-39.9.asc water.orders=SINGLE"
    "shore-caustics|Light on the sand, FFT cascades, from 4 m|$shore sea.windSpeed=4 sea.synthesiser=FFT sea.spectrum=ELFOUHAILY views.gallery.up=4 views.gallery.pitch=-25 views.gallery.yaw=70 views.gallery.right=40 water.depth=39.9 seabed.file=shore-39.9.asc"
    "shore-surf|A swell of 1.3 m and 9 s breaks on the bars and runs up the beach|$shore sea.windSpeed=5 sea.synthesiser=FFT sea.swell.0.height=1.3 sea.swell.0.period=9 sea.swell.0.direction=265 sea.swell.0.spread=8 views.gallery.up=22 views.gallery.pitch=-13 views.gallery.yaw=25 views.gallery.right=-10 views.gallery.forward=-60 water.depth=7.9 seabed.file=shore-7.9.asc"
    "shore-above|The shore from 60 m|$shore views.gallery.up=60 views.gallery.pitch=-25 water.depth=39.9 seabed.file=shore-39.9.asc"
    "water-baltic|The Baltic|$lagoon water.named=BALTIC"
    "water-harbour|A harbour|$lagoon water.named=HARBOUR water.depth=8 water.bottom=MUD"
    "wash-250|The wash of a container ship at 15 knots, from 250 m|sea.synthesiser=FFT sea.spectrum=ELFOUHAILY sea.windSpeed=7 sky.sunElevation=38 sky.sunAzimuth=350 clock.time=900 clock.reckoning=1000 entities.2.wash=true entities.2.model.name=container-ship entities.2.heading=60 entities.2.course=60 entities.2.speed=7.5 entities.2.poseTime=0 entities.2.latitude=52.5747 entities.2.longitude=5.1173 views.gallery.up=250 views.gallery.pitch=-24"
    "under-up|Under the surface, 1.5 m down: Snell's window, 5 m/s|$under views.gallery.up=-1.5 views.gallery.pitch=55"
    "under-1m|1 m down over sand, tropical water|$under sea.windSpeed=6 water.named=TROPICAL water.bottom=SAND water.depth=6 views.gallery.up=-1 views.gallery.pitch=2"
    "under-10m|10 m down, looking up|$under views.gallery.up=-10 views.gallery.pitch=45"
    "under-40m|40 m down in tropical water, looking up|$under water.named=TROPICAL views.gallery.up=-40 views.gallery.pitch=40"
    "under-bottom|Sand under 5 m of tropical water, 2 m down|$under sea.windSpeed=4 water.named=TROPICAL water.bottom=SAND water.depth=5 views.gallery.up=-2 views.gallery.pitch=-12"
    "under-hull|A yacht's hull from below|$ship sea.windSpeed=3 sky.sunElevation=55 views.gallery.up=-4 views.gallery.pitch=25 views.gallery.fieldOfView=80 water.named=TROPICAL entities.2.model.name=sailing-yacht entities.2.latitude=52.60009 entities.2.longitude=5.2 entities.2.heading=300"
    "under-split|A lens that a wave crosses, tropical water over sand|$under sea.windSpeed=6 water.named=TROPICAL water.bottom=SAND water.depth=6 views.gallery.up=-0.06 views.gallery.pitch=0"
    "under-particles|Particles in coastal water, 4 m down|$under water.jerlov=C1 water.particles=12000 views.gallery.up=-4 views.gallery.pitch=8 views.gallery.width=960 views.gallery.height=540"
    "under-foam|Foam from below, 14 m/s, 4 m down|$under sea.windSpeed=14 sea.whitecaps=3 clock.time=14 views.gallery.up=-4 views.gallery.pitch=50"
    "under-lamps|10 m down by night: sand by the lights of an underwater vehicle|views.gallery.fieldOfView=90 sea.windSpeed=3 sky.sunElevation=-40 water.named=TROPICAL water.bottom=SAND water.depth=12 water.particles=700 views.gallery.exposure=3.3 views.gallery.up=-10 views.gallery.pitch=-12 views.gallery.width=640 views.gallery.height=360 entities.2.latitude=52.6 entities.2.longitude=5.2 entities.2.altitude=-10 entities.2.heading=0 entities.2.light.height=0.7 entities.2.searchlight.on=true entities.2.searchlight.width=50 entities.2.searchlight.elevation=-14 entities.2.searchlight.intensity=8000"
    "bow|The bow wave of a container ship at 20 knots, 60 m off|sea.synthesiser=FFT sea.spectrum=ELFOUHAILY sea.windSpeed=5 sky.sunElevation=40 sky.sunAzimuth=120 clock.time=900 clock.reckoning=1000 entities.2.wake=true entities.2.wash=true entities.2.model.name=container-ship entities.2.heading=90 entities.2.course=90 entities.2.speed=10.29 entities.2.poseTime=0 entities.2.latitude=52.600539 entities.2.longitude=5.061038 views.gallery.up=22 views.gallery.pitch=-19 views.gallery.yaw=-28"
)
mkdir -p "$out"
{
    echo "# Gallery"
    echo
    echo "Drawn by \`docs/gallery/make.sh\` on the software device: FFT cascades,"
    echo "Pierson–Moskowitz, Case 1 water, automatic exposure where nothing else is"
    echo "said. Every picture starts"
    echo "from"
    echo
    echo '```sh'
    echo "build/pelagosctl set --create $common" | sed 's/  */ /g'
    echo '```'
    echo
    echo "The shores are made by"
    echo "\`docs/gallery/shore.py build/gallery/shore-7.9.asc 7.9\` (and 39.9), for"
    echo "a daemon with \`--bathymetry build/gallery\`; the winds by"
    echo "\`docs/gallery/weather.py build/gallery/pacific.nc\`, for \`--weather build/gallery\`."
} > "$out/README.md"
for picture in "${pictures[@]}"; do
    IFS='|' read -r name title settings <<< "$picture"
    if [ "$only" = "  " ] || [[ $only == *" $name "* ]]; then
        ctl unset sea water seabed sky origin >/dev/null
        ctl unset views.gallery >/dev/null 2>&1 || true
        ctl unset entities.2 >/dev/null 2>&1 || true
        # shellcheck disable=SC2086
        ctl set --create $common $settings
        ctl frame gallery "$out/$name.jpg"
        echo "gallery: $name"
    fi
    {
        echo
        echo "## $title"
        echo
        echo "![$title]($name.jpg)"
        echo
        echo '```sh'
        echo "build/pelagosctl set $settings"
        echo "build/pelagosctl frame gallery $name.jpg"
        echo '```'
    } >> "$out/README.md"
done
