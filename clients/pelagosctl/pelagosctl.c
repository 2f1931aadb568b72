/* pelagosctl: the table of commands, and main. */
#include "pelagosctl/ctl.h"

#include <locale.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

const struct ctl_option ctl_global_options[] = {
    { 's', "server", "ADDRESS",
      "Where pelagosd listens: tcp:HOST:PORT, tls:HOST:PORT or unix:PATH "
      "(PELAGOS_SERVER, "
      "else " PEL_CLIENT_DEFAULT_SERVER ")",
      NULL },
    { 0, "token-file", "FILE",
      "Where the token is that pelagosd asks for (PELAGOS_TOKEN_FILE; "
      "PELAGOS_TOKEN is the token itself)",
      NULL },
    { 't', "timeout", "SECONDS",
      "Give up waiting for an answer (10; 120 with --sweep and of plot)",
      NULL },
    { 'j', "json", NULL, "Print JSON, errors too", NULL },
    { 'q', "quiet", NULL, "Print no confirmation and no progress", NULL },
    { 'h', "help", NULL, "Say how the command is used", NULL },
    { 0, "version", NULL, "Print the version", NULL },
    { 0 },
};

static const char layer_words[] =
#define PEL_LAYER(ID, member, name, channels, samples, unit, from, text)       \
    name " "
#include "proto/layers.def"
    ;

static const char format_words[] =
#define PEL_FORMAT(ID, ending, mime, encoder, uses, text) ending " "
#include "proto/formats.def"
    ;

static const struct ctl_option frame_options[] = {
    { 0, "width", "PIXELS", "Width instead of the view's", NULL },
    { 0, "height", "PIXELS", "Height instead of the view's", NULL },
    { 0, "time", "SECONDS", "Simulated time instead of the clock's", NULL },
    { 0, "layers", "LIST", "Layers of an EXR, by commas (radiance)",
      layer_words },
    { 0, "float", NULL, "EXR samples of 32 bits instead of 16", NULL },
    { 0, "quality", "1..100", "Quality of a JPEG (90)", NULL },
    { 0, "debrief", NULL, "Of the debrief instead of the live scene", NULL },
    { 'f', "format", "FORMAT", "Format whatever the file is called",
      format_words },
    { 0 },
};
static const char *const frame_examples[] = {
    "pelagosctl frame bridge out.jpg\nThe view as it is now.",
    "pelagosctl frame bridge out.exr --layers radiance,depth,normal --float\n"
    "Linear radiance, distance and normals, for instruments.",
    "pelagosctl frame left,centre,right out_%s.png\n"
    "Three windows of one moment, to the bit.",
    NULL,
};

static const struct ctl_option surface_options[] = {
    { 0, "time", "SECONDS", "Simulated time instead of the clock's", NULL },
    { 0, "frame", "NUMBER",
      "Of the sea in that frame, one of the last 64, instead of the present",
      NULL },
    { 'a', "acceleration", NULL, "The water's acceleration too", NULL },
    { 0, "foam", NULL, "The share of the water that foam hides too", NULL },
    CTL_SERIES_OPTIONS,
    { 0 },
};
static const char *const surface_examples[] = {
    "pelagosctl surface 0 0 -20 35\nTwo points, metres east and north of the "
    "scene's origin.",
    "pelagosctl surface --acceleration --time 10 0 0\nWhat a buoy feels 10 s "
    "after the start.",
    NULL,
};

static const struct ctl_option spectrum_options[] = {
    { 'w', "wavelength", "METRES", "Sum up the waves shorter than this too",
      NULL },
    { 'n', "frequencies", "COUNT", "List S(omega) at so many, 0 to 200 (12)",
      NULL },
    { 'd', "directions", "COUNT",
      "List S(omega, theta) for so many directions too, 0 to 72 (0)", NULL },
    { 0, "lowest", "RAD/S", "The lowest frequency listed (0.2)", NULL },
    { 0, "highest", "RAD/S", "The highest (10)", NULL },
    { 0, "sweep", "AXIS...",
      "The question at each value of NAME=FIRST:LAST:STEP or NAME=VALUE,…, a "
      "number of the state; again for another axis",
      NULL },
    { 0, "format", "FORM",
      "A file for wave models, netcdf being WAVEWATCH III's; with --sweep a "
      "table (csv)",
      "ww3 swan ndbc netcdf csv json" },
    { 'o', "output", "FILE",
      "Into a file; of ndbc PATH/STATION, which gets .data_spec, .swdir, "
      ".swdir2, .swr1, .swr2",
      NULL },
    { 0 },
};
static const char *const spectrum_examples[] = {
    "pelagosctl spectrum --wavelength 1\nThe sea in force, and its waves "
    "shorter than a metre.",
    "pelagosctl --json spectrum sea.spectrum=ELFOUHAILY sea.windSpeed=10 "
    "--directions 36\nAnother sea, for a program.",
    "pelagosctl spectrum --format swan -o boundary.spc\nThe sea in force, for "
    "SWAN.",
    "pelagosctl spectrum --sweep windSpeed=2:20:2\nHeights, periods and slopes "
    "by wind, as CSV.",
    NULL,
};

static const struct ctl_option plot_options[] = {
    { 'o', "output", "FILE", "An .svg or a .png", NULL },
    { 0, "sweep", "AXIS...",
      "rrs, brdf: a line for each value of NAME=FIRST:LAST:STEP or "
      "NAME=VALUE,… (brdf: sunElevation=15,30,60)",
      NULL },
    { 0, "at", "EAST,NORTH", "height: of this place, in metres (0,0)", NULL },
    { 0, "seconds", "SECONDS", "height: from now on, 10 to 5000 (600)", NULL },
    { 0, "view", "NAME", "rows: of this view (bridge)", NULL },
    { 0 },
};
static const char *const plot_examples[] = {
    "pelagosctl plot rrs --sweep chlorophyll=0.03,0.3,3 sunZenith=40 -o "
    "rrs.svg\nRrs of three waters.",
    "pelagosctl plot brdf sea.windSpeed=12 -o brdf.png\nThe glitter's lobe "
    "under three heights of the Sun.",
    "pelagosctl plot rose sea.spectrum=JONSWAP sea.windSpeed=15 -o rose.svg\n"
    "S(omega, theta) of a sea that is not in force.",
    "pelagosctl plot height --at 50,0 --seconds 1200 -o height.png\nTwenty "
    "minutes at a place.",
    NULL,
};

static const char *const recordings_examples[] = {
    "pelagosctl recordings start night-1\nRecords from now on.",
    "pelagosctl recordings stop\nEnds that.",
    NULL,
};
static const struct ctl_option debrief_options[] = {
    { 0, "rate", "0.1..20", "Recorded seconds a second, of play", NULL },
    { 0 },
};
static const char *const debrief_examples[] = {
    "pelagosctl debrief open night-1.pelog\nThe beginning of the recording.",
    "pelagosctl debrief go 912.5\nIts moment of that simulated time.",
    "pelagosctl frame bridge then.png --debrief\nThe picture of that moment, "
    "bit "
    "for bit.",
    NULL,
};
static const char *const models_examples[] = {
    "pelagosctl models\nAll of them.",
    "pelagosctl set entities.7.model.name=tanker\nGive entity 7 a shape.",
    NULL,
};
static const char *const exercise_examples[] = {
    "pelagosctl exercise load approach\nThe scene becomes its beginning.",
    "pelagosctl exercise start\nIt runs.",
    "pelagosctl exercise rewind 300\nBack to 5 min after its start; it is "
    "paused then.",
    "pelagosctl exercise facts >facts.csv\nWhat the trainee did, second by "
    "second.",
    NULL,
};
static const char *const cluster_examples[] = {
    "pelagosctl cluster\nWho is the master, and whether all show the same.",
    "pelagosctl cluster place left render-2\nrender-2 draws the view left; a "
    "spare does while it is gone.",
    NULL,
};
static const char *const model_examples[] = {
    "pelagosctl model check ferry/ferry.glb\nBefore it goes into the directory "
    "of pelagosd --models.",
    NULL,
};

static const struct ctl_option preset_options[] = {
    { 0, "title", "TEXT", "With save: what people call it", NULL },
    { 0, "patch", "JSON",
      "With save: this change, as PATCH /v1/state takes it, instead of sea, "
      "sky and water as they are",
      NULL },
    { 0 },
};
static const char *const preset_examples[] = {
    "pelagosctl preset save storm --title 'Autumn storm'\nKeep sea, sky and "
    "water as they are now.",
    "pelagosctl preset apply storm\nAnd bring them back.",
    NULL,
};

static const struct ctl_option watch_options[] = {
    { 'n', "count", "LINES", "End after so many lines", NULL },
    { 0, "seconds", "SECONDS", "End after so long", NULL },
    { 0 },
};

static const struct ctl_option replay_options[] = {
    { 'x', "speed", "FACTOR", "Times the pace of the log, 0.01 to 100 (1)",
      NULL },
    { 0, "to", "HOST:PORT", "Where NMEA is received (127.0.0.1:10110)", NULL },
    { 'l', "loop", NULL, "Begin again at the end, until interrupted", NULL },
    { 0, "no-clock", NULL, "Leave the clock of pelagosd alone", NULL },
    { 0, "frames", "DIRECTORY", "Save frames of a command log here, as PNG",
      NULL },
    { 0, "view", "VIEW", "The view to save (bridge)", NULL },
    { 0, "every", "SECONDS", "Simulated time between two frames (1)", NULL },
    { 0, "at", "LIST",
      "Save frames of these simulated times only, each where the clock first "
      "shows it",
      NULL },
    { 0 },
};
static const char *const replay_examples[] = {
    "pelagosctl replay voyage.nmea --speed 10\nTen minutes of log in one.",
    "pelagosctl replay bug.pelog --frames out --every 0.5\nThe frames of a "
    "recorded session, two for each of its seconds.",
    "pelagosctl replay bug.pelog bug.pelog.0*\nAll segments of a long "
    "recording.",
    NULL,
};

static const struct ctl_option record_options[] = {
    { 0, "seconds", "SECONDS", "How long (10)", NULL },
    { 0, "fps", "RATE", "Frames a second, 1 to 60 (15)", NULL },
    { 0, "exact", NULL,
      "Draw each frame for its own moment however long that takes, instead of "
      "live",
      NULL },
    { 0, "from", "SECONDS", "Simulated time of the first frame (the present)",
      NULL },
    { 0, "waypoints", "FILE",
      "Have the view go this way, and record it from its beginning to its end, "
      "each frame for its own moment",
      NULL },
    { 0, "stream", NULL,
      "Save the H.264 that viewers get, as it comes, without encoding again",
      NULL },
    { 0, "url", "URL",
      "pelagosd's HTTP, for --stream ($PELAGOS_URL or http://127.0.0.1:8080)",
      NULL },
    { 0, "bitrate", "KBPS", "Of --stream, 100 to 100000 (by the size)", NULL },
    { 0, "width", "PIXELS", "Width instead of the view's", NULL },
    { 0, "height", "PIXELS", "Height instead of the view's", NULL },
    { 0, "quality", "1..100", "Quality of the JPEGs (90)", NULL },
    { 0, "layers", "LIST", "Layers of the EXRs, by commas (radiance)",
      layer_words },
    { 0, "float", NULL, "EXRs in 32-bit samples instead of 16", NULL },
    { 0, "resume", NULL, "Draw only the files of the sequence that are missing",
      NULL },
    { 0, "overwrite", NULL, "Replace what is there", NULL },
    { 0 },
};
static const char *const record_examples[] = {
    "pelagosctl record bridge clip.mkv --seconds 20\nMotion-JPEG in Matroska.",
    "pelagosctl record bridge clip.mp4 --fps 30 --exact\nH.264, every frame "
    "exactly 1/30 s after the last.",
    "pelagosctl record bridge clip.mp4 --stream --seconds 60\nA minute of "
    "what viewers see.",
    "pelagosctl record climb climb.mp4 --fps 25 --waypoints climb.csv\nA film "
    "along a way, say from 2 m to 400 km.",
    "pelagosctl record bridge out/b_%05d.exr --fps 25 --layers "
    "radiance,depth\nA sequence of EXRs, 1/25 s apart.",
    NULL,
};

static const struct ctl_option bench_options[] = {
    { 0, "seconds", "SECONDS", "How long each row runs (3)", NULL },
    { 0, "sizes", "LIST", "Sizes to try (640x360,1280x720,1920x1080)", NULL },
    { 0, "views", "LIST", "Views, asked for at once (the first view)", NULL },
    { 0, "points", "N",
      "Ask for the surface at N points beside, 60 times a second", NULL },
    { 0 },
};
static const char *const bench_examples[] = {
    "pelagosctl bench --views bridge,wing --sizes 1280x720\n"
    "Two views at a time.",
    NULL,
};

static const struct ctl_option optics_options[] = {
    { 0, "absorption", "R,G,B",
      "Absorption at 680, 550, 440 nm, or one for all, 1/m", NULL },
    { 0, "scattering", "R,G,B", "Scattering, 1/m", NULL },
    { 0, "asymmetry", "R,G,B", "Mean cosine of scattering (0.924)", NULL },
    { 0, "chlorophyll", "MG", "Chlorophyll instead, mg/m3 (0.2)", NULL },
    { 0, "cdom", "A",
      "Absorption of dissolved matter at 440 nm, 1/m (by chlorophyll)", NULL },
    { 0, "cdom-slope", "S", "Its fall, 0.005 to 0.03 1/nm (0.014)", NULL },
    { 0, "detritus", "A",
      "Absorption of other particles at 440 nm, 1/m (by chlorophyll)", NULL },
    { 0, "detritus-slope", "S", "Its fall, 0.005 to 0.03 1/nm (0.011)", NULL },
    { 0, "minerals", "G/M3", "Suspended minerals, 0 to 100 (0)", NULL },
    { 0, "backscatter-ratio", "RATIO",
      "Backscattered fraction of particles, 0.001 to 0.06 (by chlorophyll, or "
      "the water's)",
      NULL },
    { 0, "phase", "FUNCTION",
      "Of particles: fournier-forand, henyey-greenstein (fournier-forand)",
      NULL },
    { 0, "no-raman", NULL, "Without Raman scattering by the water", NULL },
    { 0, "wavelengths", "NM",
      "400 to 700, with commas between, or FROM:TO:STEP (680,550,440)", NULL },
    { 0, "jerlov", "TYPE",
      "Jerlov's type instead: I, IA, IB, II, III, 1C, 3C, 5C, 7C, 9C", NULL },
    { 0, "name", "WATER", "tropical, north-atlantic, baltic, harbour instead",
      NULL },
    { 0, "salinity", "G/KG", "Salinity, 0 to 42 (35)", NULL },
    { 0, "temperature", "DEGREES", "Celsius, -2 to 40 (15)", NULL },
    { 0, "depth", "METRES", "Depth, 0.1 to 11000 (1000)", NULL },
    { 0, "bottom", "KIND",
      "sand, mud, rock, coral, black (black), or an albedo, or R,G,B", NULL },
    { 0, "sun-zenith", "DEGREES", "From the vertical to the Sun, 0 to 90 (30)",
      NULL },
    { 0, "view-zenith", "DEGREES",
      "From the vertical to the eye, 0 to 90 (water 0, brdf 60)", NULL },
    { 0, "azimuth", "DEGREES",
      "water: of the line of sight from the Sun's, 0 looks towards it; sky: of "
      "the direction (0)",
      NULL },
    { 0, "orders", "WHICH",
      "all, 2, or as Iwasaki et al. 2003: paper, single (all)", NULL },
    { 0, "from", "CODE",
      "reference; gpu, the code that draws, from a running pelagosd; "
      "water: montecarlo too (reference)",
      NULL },
    { 0, "paths", "COUNT", "Of the Monte Carlo, a wavelength (100000)", NULL },
    { 0, "seed", "NUMBER", "Of the Monte Carlo (1)", NULL },
    { 0, "wind", "M/S", "brdf: short for sea.windSpeed=", NULL },
    { 0, "slope-along", "VARIANCE",
      "brdf: slope variance along the wind (that of the sea)", NULL },
    { 0, "slope-cross", "VARIANCE", "brdf: across the wind", NULL },
    { 0, "view-azimuth", "DEGREES",
      "brdf: compass direction to the eye (opposite the Sun)", NULL },
    { 0, "height", "METRES", "sky: of the eye, 0.5 to 1e6 (2)", NULL },
    { 0, "elevation", "DEGREES", "sky: of the direction, -90 to 90 (45)",
      NULL },
    { 0, "sun-elevation", "DEGREES",
      "brdf, sky: short for sky.sunElevation=", NULL },
    { 0, "sun-azimuth", "DEGREES",
      "brdf, sky: short for sky.sunAzimuth=", NULL },
    { 0, "visibility", "METRES", "sky: short for sky.visibility=", NULL },
    CTL_SERIES_OPTIONS,
    { 0 },
};
static const char *const optics_examples[] = {
    "pelagosctl optics water --jerlov IA --depth 8 --bottom sand --sun-zenith "
    "40\nA lagoon from straight above.",
    "pelagosctl optics water --chlorophyll 0.5 --wavelengths 400:700:10\n"
    "Constituents, Rrs, R and Kd of open ocean.",
    "pelagosctl optics water --absorption 0.02 --scattering 0.3 --from "
    "montecarlo\nThe same by counting photons.",
    "pelagosctl optics brdf --wind 10 --sun-elevation 20 --view-zenith 75\n"
    "How the sea of 10 m/s reflects the Sun.",
    "pelagosctl optics sky --sun-elevation 5 --elevation 10 --from gpu\n"
    "The sky over a low Sun, as the shaders have it.",
    "pelagosctl optics water --sweep wavelength=400:700:5 --sweep "
    "chlorophyll=0.1,1,10 -o rrs.nc\nThree waters, as NetCDF.",
    "pelagosctl optics brdf --wind 8 --sweep sunElevation=5:85:5 --sweep "
    "viewZenith=0:85:5\nA table of the BRDF, as CSV.",
    NULL,
};

static const struct ctl_option dataset_options[] = {
    { 'o', "output", "DIR", "The set's directory (the plan's name)", NULL },
    { 'w', "workers", "COUNT", "Processes, each with a pelagosd (4, or cores)",
      NULL },
    { 0, "device", "LIST",
      "pelagosd --device of the workers in turn, by commas", NULL },
    { 0, "threads", "COUNT",
      "That a worker's software device may keep busy (its share of the cores)",
      NULL },
    { 0, "slurm", "HOW", "run: print or submit a job array instead",
      "print submit" },
    { 0, "sbatch", "OPTION...", "A line more for sbatch, as --partition=cpu",
      NULL },
    { 0, "tasks", "COUNT", "Of the array, 1000 at most (a task a shard)",
      NULL },
    { 0, "task", "NUMBER", "work: shards NUMBER, NUMBER + tasks, … alone",
      NULL },
    { 0, "no-estimate", NULL, "run: do not measure what it will take", NULL },
    { 0, "partial", NULL, "merge: of the shards that are there", NULL },
    { 0 },
};
static const char *const dataset_examples[] = {
    "pelagosctl dataset plan harbour.json\nChecks the plan, draws a few of its "
    "frames, says what all of them take.",
    "pelagosctl dataset run harbour.json --workers 4\nDraws it into harbour/; "
    "the same again goes on where it was.",
    "pelagosctl dataset run harbour.json --slurm submit\nThe same by a "
    "cluster.",
    NULL,
};

static const char *const get_examples[] = {
    "pelagosctl get\nEverything, one field a line.",
    "pelagosctl get sea.windSpeed\nThe bare value, for scripts.",
    "pelagosctl get views.bridge entities.ownship.heading\nParts of it.",
    NULL,
};
static const struct ctl_option set_options[] = {
    { 0, "create", NULL, "Add views and entities that are not there yet",
      NULL },
    { 0 },
};
static const char *const set_examples[] = {
    "pelagosctl set sea.windSpeed=12 views.bridge.yaw=-30\n"
    "Both at once, or neither.",
    "pelagosctl set --create views.wing.entity=1 views.wing.right=12 "
    "views.wing.yaw=90\nA new view.",
    NULL,
};
static const char *const unset_examples[] = {
    "pelagosctl unset sky.sunElevation\nThe Sun by date and place again.",
    "pelagosctl unset views.wing\nThe view is gone.",
    NULL,
};
static const char *const completion_examples[] = {
    "pelagosctl completion bash "
    ">~/.local/share/bash-completion/completions/pelagosctl\n"
    "For the next shell.",
    NULL,
};

const struct ctl_command ctl_commands[] = {
    { "get", "[PATH…]", "print the state, or parts of it",
      "Prints every field of the state as `path = value unit`, or those at and "
      "below the PATHs. One PATH that is a field prints its bare value.\n\n"
      "Elements of lists are named by their key: views by name "
      "(views.bridge), entities by id or unique name (entities.1).",
      NULL, get_examples, "paths", 0, SIZE_MAX, ctl_get },
    { "set", "PATH=VALUE…", "change fields, all at once or none",
      "Sends all assignments as one edit: either every one takes effect in "
      "the same frame, or none does and the reason is printed. A view or "
      "entity that is not there is refused, or added with --create.",
      set_options, set_examples, "paths", 1, SIZE_MAX, ctl_set },
    { "unset", "PATH…", "reset fields, remove views and entities",
      "Gives fields their default, removes elements of lists, empties lists.",
      NULL, unset_examples, "paths", 1, SIZE_MAX, ctl_unset },
    { "watch", "[PATH…]", "print fields as they change",
      "Prints one line for each field that changes, until interrupted. "
      "Without PATH all but clock.time, poseTime and revision.",
      watch_options, NULL, "paths", 0, SIZE_MAX, ctl_watch },
    { "views", "", "list the views",
      "Prints a line for each view: name, size, field of view, the entity it "
      "is fixed to, and the camera.",
      NULL, NULL, NULL, 0, 0, ctl_views },
    { "frame", "VIEW[,VIEW…] FILE", "save a picture, or several of one frame",
      "Saves the view as it is now (or at --time) as a picture in the "
      "format of FILE's ending, one of --format's. `-` is standard output, "
      "with --format.\n\n"
      "Several views, separated by commas, are drawn in one frame, of one "
      "state at one moment, clock running or not; each is saved into FILE with "
      "its name in place of %s.",
      frame_options, frame_examples, "views", 2, 2, ctl_frame },
    { "surface", "EAST NORTH [EAST NORTH…]",
      "ask for the sea's height, normal, velocity and depth",
      "Answers from the very surface that is drawn. EAST and NORTH are metres "
      "from the scene's origin. Depth is below mean sea level, sounding below "
      "the surface of the moment; where seabed.file has no data they are `-`.",
      surface_options, surface_examples, NULL, 2, 20000, ctl_surface },
    { "spectrum", "[PATH=VALUE…]", "print the numbers of the sea",
      "Prints significant wave height, peak period, mean direction, slope "
      "variances along and across the wind, and the spectrum S(omega), of the "
      "sea in force or of the one that the assignments would make of it; "
      "nothing is changed. `spectrum` is its integral, `drawn` the sum of the "
      "waves that are drawn and of the slopes that only shading shows. "
      "Directions are those the waves come from.",
      spectrum_options, spectrum_examples, "paths", 0, SIZE_MAX, ctl_spectrum },
    { "plot", "rrs|brdf|rose|height|rows [NAME=VALUE…] [PATH=VALUE…]",
      "draw numbers as SVG or PNG",
      "rrs draws remote-sensing reflectance over wavelength; brdf the lobe of "
      "the reflected Sun in its plane; rose the directional spectrum; height "
      "the surface at a place over time, with 4 sigma of it and of the "
      "spectrum; rows the radiance of a view's picture by its rows. NAME=VALUE "
      "sets a number of the question (sunZenith=40), PATH=VALUE one of the "
      "state for this plot only. pelagosd answers, pelagos-plot of "
      "python3-pelagos draws, by python3-matplotlib. Title, question and "
      "version are in the file's metadata.",
      plot_options, plot_examples, "paths", 1, SIZE_MAX, ctl_plot },
    { "models", "[NAME]", "list the models of ships and marks",
      "Prints a line for each model that entities.*.model.name can name: "
      "class, size over all in metres, triangles of each level of detail, "
      "memory. Built-in ones first, then the files of pelagosd --models, with "
      "what is wrong with a file or what was left out of it.",
      NULL, models_examples, NULL, 0, 1, ctl_models },
    { "preset", "list|save|apply|delete [NAME]",
      "keep seas, skies and waters under names",
      "list prints name, title and change of each; save keeps sea, sky and "
      "water as they are, or the change of --patch, under NAME, which takes "
      "the place of one of that name; apply makes the change; delete removes "
      "it. pelagosd keeps them with its state.",
      preset_options, preset_examples, NULL, 1, 2, ctl_preset },
    { "model", "check FILE", "say what is wrong with a model's file",
      "Reads FILE, and the description FILE.json beside it, as pelagosd does, "
      "without one, and prints what it is, or why it is refused. Exit status 1 "
      "then.",
      NULL, model_examples, "files", 2, 2, ctl_model },
    { "recordings", "[list|start [NAME]|stop]",
      "list, begin and end recordings on the server",
      "Prints the command logs in the directory of pelagosd --recordings: "
      "file, "
      "UTC of the beginning, simulated times from and to, size. start begins "
      "NAME.pelog there, or one named by the date.",
      NULL, recordings_examples, NULL, 0, 2, ctl_recordings },
    { "debrief", "[status|open NAME|go SECONDS|play|pause|close]",
      "lead a second scene through a recording",
      "open reads a recording of pelagosd --recordings; go brings the debrief "
      "to its last moment of that simulated time, play lets it go on. The live "
      "scene and its streams are not touched. Its views are drawn by the same "
      "renderer: `frame --debrief`, and /v1/debrief of HTTP.",
      debrief_options, debrief_examples, NULL, 0, 2, ctl_debrief },
    { "exercise", "[VERB [ARGUMENTS]]", "load, run and rewind exercises",
      "Without arguments, or with `status`: which exercise is loaded, how far "
      "it is, what has happened and what comes next. `list`: the exercises of "
      "pelagosd --exercises. `show NAME` prints one as JSON; `check FILE` says "
      "what is wrong with one; `save NAME FILE` keeps it, if it is good; "
      "`delete NAME` removes it. `load NAME` puts the scene into its "
      "beginning, "
      "`start` runs it or goes on, `pause` holds it, `rewind SECONDS` goes "
      "back "
      "to that exercise time and pauses, `stop` ends it. `facts [SHIP]` prints "
      "what was logged of own ship and its targets as CSV, of several own "
      "ships those of the one with that number.",
      NULL, exercise_examples, NULL, 0, 3, ctl_exercise },
    { "cluster", "[place VIEW NODE|unplace VIEW]",
      "list the nodes of an exercise on several machines, place views",
      "Of each node of pelagosd --exercise, as it said within the last second: "
      "its role, the last sealed frame that it shows and by how many it is "
      "behind, the digest of its state then, the time from a seal to its "
      "pictures, its clock minus the master's, what went wrong, and where it "
      "is reached. A node that says nothing is silent. Then the views that are "
      "placed, where, who draws each now, and where that one is reached.\n\n"
      "place VIEW NODE places a view at a node, which need not be there, "
      "whatever node is asked; while that one is gone a spare (pelagosd "
      "--exercise-spare) draws it. unplace VIEW: nobody in particular does.",
      NULL, cluster_examples, NULL, 0, 3, ctl_cluster },
    { "step", "[SECONDS]", "advance simulated time in mode STEPPED",
      "Advances the clock by SECONDS (1/30) and prints the new time. Only in "
      "clock.mode STEPPED.",
      NULL, NULL, NULL, 0, 1, ctl_step },
    { "replay", "FILE…", "play a log of NMEA sentences or of commands",
      "Sends the sentences of FILE over UDP at the pace of their time stamps "
      "(RMC, else GGA, GLL or ZDA; a group a second where there are none), "
      "times --speed. For its duration clock.mode is FREE and clock.rate the "
      "speed; afterwards they are as before.\n\n"
      "A FILE that pelagosd --record wrote is played as commands instead: the "
      "state of its beginning, then every command at its recorded simulated "
      "time, in clock.mode STEPPED, as fast as it goes or at --speed times "
      "the pace of the recording. Frames saved on the way are the same bits "
      "each time on the same renderer. The end of the log stays. Several "
      "FILEs are the segments of one recording, in any order: they are played "
      "as one log; each of them can be played alone.",
      replay_options, replay_examples, "files", 1, SIZE_MAX, ctl_replay },
    { "record", "VIEW FILE", "save a clip",
      "Records the view into FILE: .mjpeg (bare JPEGs), .mkv "
      "(Motion-JPEG as pelagosd encoded it), .mp4 (H.264; needs GStreamer's "
      "x264enc or openh264enc). Live, frames that are not drawn in time are "
      "left out; with --exact none is.\n\n"
      "With --stream it is the live stream itself, H.264 by pelagosd's rate, "
      "scale and encoder, into .mkv or .mp4, over HTTP. Its time stamps are "
      "those of the frames.\n\n"
      "--waypoints sets views.VIEW.waypoints, which stay, and takes from the "
      "view what else places it. The FILE is CSV whose first line names its "
      "columns (time,latitude,longitude,height,heading,pitch,roll; all but "
      "latitude and longitude may be left out), or a JSON list of Waypoint.\n\n"
      "A FILE with the ending of a picture (.exr, and what else --format of "
      "frame takes) is a sequence of files, each "
      "frame drawn in full for its exact simulated time; %05d in the name is "
      "the number's place. Each file is written whole or not at all, so that "
      "an interrupted sequence goes on with --resume, at the same times. "
      "Nothing that exists is replaced without --overwrite.",
      record_options, record_examples, "views", 2, 2, ctl_record },
    { "bench", "", "measure the running pelagosd",
      "Asks for JPEGs as fast as they come, for each size with each set of "
      "views, and prints frames a second and median and 95th percentile of "
      "drawing and of the whole answer; with --points also median and 99th "
      "percentile of a surface query, asked in real time (SCHED_RR) where the "
      "system permits it, as the loop of a simulator on this machine should "
      "be run (chrt -r 2 PROGRAM); the class says whether it was.",
      bench_options, bench_examples, NULL, 0, 0, ctl_bench },
    { "optics", "water|brdf|sky [PATH=VALUE…]",
      "print numbers of light: water, reflection, sky",
      "water prints as JSON the radiance just above a flat sea for a unit of "
      "solar "
      "irradiance normal to the beam, at 680, 550 and 440 nm: single, second "
      "and higher orders, and what touched the bottom, direct and scattered. "
      "Computed here by the reference code of the server; "
      "pelagosd is not asked.\n\n"
      "brdf prints the terms of Ross's BRDF for one direction of view: slope "
      "density, shadowing, effective Fresnel reflectance, the Sun's "
      "reflection. sky prints the sky's radiance and the air's transmittance "
      "in a direction and towards the Sun, at 680, 550 and 440 nm. Both ask "
      "pelagosd about the state in force, or about what the PATHs make of it, "
      "for this answer only: its reference code or, --from gpu, the shader "
      "functions that draw, on the device that draws.\n\n"
      "With --sweep, --format or --output all three are series: pelagosd "
      "answers the question at each combination of the axes' values. Of water "
      "an axis may be sunZenith, viewZenith, azimuth, wavelength or a number "
      "of "
      "water.*; of brdf and sky also time and any number of the state.",
      optics_options, optics_examples, "paths", 1, SIZE_MAX, ctl_optics },
    { "dataset", "plan|run|status|merge|work PLAN|DIR",
      "draw labelled frames by the million",
      "plan reads a plan (docs/datasets.md), refuses what is unknown or out of "
      "range, draws a few of its frames, and prints what the set will take. "
      "run does so and draws it: shards of a directory, each whole or not "
      "there, then index.parquet, annotations.json (COCO) and README.md of "
      "all. Whatever is killed meanwhile, the same command goes on, and comes "
      "to the same bits. status DIR says how far it is, merge DIR writes "
      "index, "
      "annotations and README.md anew, work DIR is one worker more, on any "
      "machine that sees the directory. Each worker starts a pelagosd of its "
      "own; --server is not asked. pelagos-dataset of python3-pelagos does it, "
      "with python3-numpy.",
      dataset_options, dataset_examples, "files", 2, 2, ctl_dataset },
    { "completion", "bash|zsh|fish", "print the completion of a shell",
      "Prints a script that completes commands, options, and the paths and "
      "views of the running pelagosd.",
      NULL, completion_examples, "shells", 1, 1, ctl_completion },
    { "help", "[COMMAND]", "say how a command is used",
      "Prints the commands, or the options of one.", NULL, NULL, "commands", 0,
      1, ctl_help },
    /* For the build and for shells; without summary they are not listed. */
    { "manual", "", NULL, "Prints the manual page.", NULL, NULL, NULL, 0, 0,
      ctl_manual },
    { "complete", "KIND", NULL, "Prints words for a completion.", NULL, NULL,
      NULL, 1, 1, ctl_complete },
    { 0 },
};

int main(int argc, char **argv)
{
    setlocale(LC_CTYPE, "");
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN); /* a file that may not grow is an error */
    struct ctl ctl;
    enum ctl_exit status = ctl_parse(&ctl, argc, argv);
    if (status == CTL_DONE) {
        if (ctl_flag(&ctl, "help")) {
            ctl_print_help(stdout, ctl.command);
        } else if (ctl_flag(&ctl, "version")) {
            puts("pelagosctl " PEL_VERSION);
        } else {
            /* Every connection of a command gives it. */
            if (ctl_value(&ctl, "token-file")) {
                unsetenv(PEL_CLIENT_TOKEN_VARIABLE);
                setenv(PEL_CLIENT_TOKEN_FILE_VARIABLE,
                       ctl_value(&ctl, "token-file"), 1);
            }
            status = ctl.command->run(&ctl);
        }
    }
    pel_client_close(ctl.client);
    g_free(ctl.args);
    if (status == CTL_DONE && (fflush(stdout) != 0 || ferror(stdout))) {
        status = CTL_FAILED;
    }
    return (int)status;
}
