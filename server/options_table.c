/* Every option, in the order of help and manuals. */
#include "options.h"

#include <stddef.h>

#include "frames/frames.h"

#define FIELD(name) offsetof(struct pel_options, name)

static const char *const framing_words[] = { "tcp", "rtu", NULL };
static const char *const order_words[] = { "abcd", "cdab", "badc", "dcba",
                                           NULL };
static const char *const checksum_words[] = { "required", "optional", NULL };
static const char *const wind_words[] = { "off", "given", "mean", NULL };
static const char *const traffic_words[] = { "off", "ttm", "ais", "both",
                                             NULL };
static const char *const gone_words[] = { "resume", "hold", NULL };
static const char *const quality_words[] = { "auto", "full", NULL };
static const double quality_values[] = { 0.0, 1.0 };
static const char *const shading_words[] = { "auto", "fragment", "compute",
                                             NULL };
static const char *const reflection_words[] = { "drawn", "paper", NULL };
static const char *const realtime_words[] = { "auto", "off", "on", NULL };
static const char *const form_words[] = { "auto", "text", "json", "journal",
                                          NULL };
static const char *const full_words[] = { "refuse", "continue", NULL };
static const char *const level_words[] = { "error", "warning", "info", "debug",
                                           NULL };

const struct pel_option pel_option_table[] = {
    { "http", "network", PEL_OPTION_ADDRESS, "ADDRESS:PORT|off",
      "127.0.0.1:8080", .offset = FIELD(http),
      .help = "Where HTTP is served: the page, /v1, /metrics, /healthz." },
    { "tcp", "network", PEL_OPTION_ADDRESS, "ADDRESS:PORT|off",
      "127.0.0.1:7878", .offset = FIELD(tcp),
      .help = "Where length-delimited protobuf is served over TCP." },
    { "unix", "network", PEL_OPTION_PATH, "PATH|off", "off",
      .offset = FIELD(unix_path),
      .help = "Unix socket for length-delimited protobuf, mode 0600." },
    { "rtsp", "network", PEL_OPTION_ADDRESS, "ADDRESS:PORT|off",
      "127.0.0.1:8554", .offset = FIELD(rtsp),
      .help = "Where RTSP is served: rtsp://ADDRESS:PORT/VIEW, in H.264." },
    { "whep-ports", "network", PEL_OPTION_TEXT_KIND, "FIRST-LAST", "",
      .offset = FIELD(whep_ports),
      .help = "UDP ports that WebRTC's media leave from, one a session (a "
              "firewall wants to know them); absent: any free one." },
    { "whep-servers", "network", PEL_OPTION_LIST, "URLS", "",
      .element = pel_options_relay, .secret = true,
      .offset = FIELD(whep_servers),
      .help = "Servers of STUN and TURN for WebRTC, separated by commas: "
              "stun://HOST:PORT, turn://USER:PASSWORD@HOST:PORT. Absent: none, "
              "media go from the addresses of --http." },
    { "whep-peers", "network", PEL_OPTION_LIST, "NETWORKS", "",
      .element = pel_options_network, .offset = FIELD(whep_peers),
      .help = "Addresses and networks (10.0.0.0/8), separated by commas, that "
              "offers of WebRTC may name as a player's beside the address that "
              "asks. With --whep-servers they are sent checks of ICE; absent: "
              "only the address that asks is." },
    { "http-hosts", "network", PEL_OPTION_LIST, "NAMES", "",
      .element = pel_options_host, .offset = FIELD(http_hosts),
      .help = "Names, separated by commas, that a proxy may give as Host." },
    { "allow-origin", "network", PEL_OPTION_LIST, "ORIGINS", "",
      .element = pel_options_origin, .offset = FIELD(allow_origin),
      .help = "Origins (https://desk.example), separated by commas, whose "
              "pages may show pictures and live views of this server." },
    { "trust-proxy", "network", PEL_OPTION_LIST, "ADDRESSES", "",
      .element = pel_options_numeric, .offset = FIELD(trust_proxy),
      .help = "Addresses of proxies, separated by commas (127.0.0.1 for nginx "
              "here), whose X-Forwarded-For names the client that a "
              "connection is counted for." },
    { "token-file", "network", PEL_OPTION_PATH, "FILE|off", "off",
      .offset = FIELD(token_file),
      .help = "Clients of HTTP, RTSP and the protobuf port must give the "
              "token in this file (mode 600 or 640); needed where one of them "
              "is not on loopback. SIGHUP reads it again." },
    { "tls-cert", "network", PEL_OPTION_PATH, "FILE|off", "off",
      .offset = FIELD(tls_cert),
      .help = "Certificate in PEM: the RTSP and protobuf ports speak TLS "
              "only. HTTP gets its TLS from nginx. SIGHUP reads it again." },
    { "tls-key", "network", PEL_OPTION_PATH, "FILE|off", "off",
      .offset = FIELD(tls_key),
      .help = "Key of --tls-cert in PEM (mode 600 or 640)." },
    { "plain", "network", PEL_OPTION_FLAG, "", "no", .offset = FIELD(plain),
      .help = "Lets HTTP, RTSP and protobuf leave loopback without TLS: for a "
              "container or a network of its own behind a proxy. Whoever "
              "hears the traffic then has the token." },

    { "state", "scene", PEL_OPTION_PATH, "FILE|off", "off",
      .offset = FIELD(state),
      .help =
          "Keeps the scene in this file and loads it at start; one daemon at "
          "a time. An edit is in FILE.journal before it is answered: kill -9 "
          "loses none, a power failure those of the last 0.2 s. A file that "
          "does not load is kept as FILE.bad (.bad.2 to .9); one of a newer "
          "version is refused and stays as it is. With --exercise it is a "
          "copy of the last sealed state, without a journal "
          "(docs/cluster.md)." },
    { "journal-full", "scene", PEL_OPTION_CHOICE, "HOW", "refuse",
      .choices = full_words, .offset = FIELD(journal_full),
      .help = "When the disk is full and what is reserved for FILE.journal is "
              "used up: an edit is refused (HTTP 507), or takes effect, is "
              "answered with X-Pelagos-Volatile, and a kill loses it." },
    { "record", "scene", PEL_OPTION_PATH, "FILE|off", "off",
      .offset = FIELD(record),
      .help = "Writes every accepted command with its simulated time into "
              "this log, for `pelagosctl replay`; when it is full it becomes "
              "FILE.000001 and so on, and FILE begins anew with the whole "
              "state. With --exercise, on any node, what is sealed." },
    { "record-segment", "scene", PEL_OPTION_DOUBLE, "MIB", "64", 0.0625, 65536,
      "MiB", .offset = FIELD(record_segment_mib),
      .help = "Size at which --record begins a new segment." },
    { "record-keep", "scene", PEL_OPTION_INT, "COUNT", "16", 2, 100000,
      "segments", .offset = FIELD(record_keep),
      .help = "Full segments of --record to keep, or as many bytes of shorter "
              "ones, as restarts leave them, in at most 500 files; the oldest "
              "go first." },
    { "record-days", "scene", PEL_OPTION_DOUBLE, "DAYS", "0", 0, 36500, "d",
      .offset = FIELD(record_days),
      .help = "Segments of --record that ended longer ago are removed when the "
              "next one begins; 0: none is, for its age." },
    { "recordings", "scene", PEL_OPTION_PATH, "DIRECTORY|off", "off",
      .offset = FIELD(recordings),
      .help =
          "Where clients may begin recordings, as --record writes them, and "
          "from where they are opened for a debrief." },
    { "waves", "scene", PEL_OPTION_INT, "COUNT", "60", 20, 256, "trochoids",
      .offset = FIELD(waves),
      .help = "Number of waves of a sea of TROCHOIDS." },
    { "spectra", "scene", PEL_OPTION_PATH, "DIRECTORY|off", "off",
      .offset = FIELD(spectra),
      .help = "Where the files of spectra lie that sea.measured names." },
    { "bathymetry", "scene", PEL_OPTION_PATH, "DIRECTORY|off", "off",
      .offset = FIELD(bathymetry),
      .help = "Where the files of heights lie that seabed.file names: GeoTIFF, "
              "NetCDF, HDF5, BAG, ENVI, ESRI .hdr and ASCII grids, OpenEXR." },
    { "weather", "scene", PEL_OPTION_PATH, "DIRECTORY|off", "off",
      .offset = FIELD(weather),
      .help = "Where the files of wind and waves lie that sea.field.file "
              "names: GRIB, NetCDF." },
    { "panoramas", "scene", PEL_OPTION_PATH, "DIRECTORY|off", "off",
      .offset = FIELD(panoramas),
      .help = "Where the pictures lie that sky.file names: OpenEXR, Radiance "
              ".hdr." },
    { "models", "scene", PEL_OPTION_PATH, "DIRECTORY|off", "off",
      .offset = FIELD(models),
      .help = "Where the files lie that entities.*.model.name names: glTF, "
              "GLB, OBJ, COLLADA, 3DS, AC3D, STL, X." },
    { "exercises", "scene", PEL_OPTION_PATH, "DIRECTORY|off", "off",
      .offset = FIELD(exercises),
      .help = "Where the exercises lie, NAME.json; pelagosctl exercise loads "
              "and saves them." },

    { "device", "render", PEL_OPTION_LIST,
      "all|auto|software|NUMBER[,NUMBER...]", "auto",
      .element = pel_options_device, .offset = FIELD(device),
      .help = "EGL device to draw with: hardware if there is any, the "
              "processor, or the device of that number; of several the views "
              "are spread over all, of a list over those in it, and one that "
              "is lost leaves its views to the others." },
    { "fps", "render", PEL_OPTION_DOUBLE, "HZ", "30", 1, 240, "Hz",
      .live = true, .offset = FIELD(fps),
      .help = "Most frames a second of live views." },
    { "quality", "render", PEL_OPTION_DOUBLE, "auto|full|SCALE", "auto", 0.25,
      1, "of width and height", .choices = quality_words,
      .values = quality_values, .live = true, .offset = FIELD(quality),
      .help = "How finely live views are drawn before they are scaled to "
              "their size: as finely as holds --fps, in full, or at a fixed "
              "scale. Pictures that are asked for are always drawn in full." },
    { "encoder-threads", "render", PEL_OPTION_INT, "COUNT", "0", 0,
      PEL_MAX_ENCODERS, "threads", .offset = FIELD(encoder_threads),
      .help = "Threads that encode pictures; 0 is one a core, of more than 4 "
              "cores one less, at most 64." },
    { "video-encoder", "render", PEL_OPTION_TEXT_KIND, "auto|ELEMENT", "auto",
      .offset = FIELD(video_encoder),
      .help = "GStreamer element that makes H.264 (nvh264enc, vah264enc, "
              "vah264lpenc, x264enc, openh264enc); auto is the first of these "
              "that works." },
    { "realtime", "render", PEL_OPTION_CHOICE, "WHEN", "auto",
      .choices = realtime_words, .offset = FIELD(realtime),
      .help =
          "Whether the threads that read requests and answer surface "
          "queries run in real time (SCHED_RR) for up to two fifths "
          "of a core each, so that they do not wait for drawing: auto is where "
          "the system permits it (ulimit -r 2, systemd's LimitRTPRIO=2), "
          "on refuses to start where it does not." },

    { "modbus", "bridges", PEL_OPTION_ADDRESS, "ADDRESS:PORT|off",
      "127.0.0.1:1502", .offset = FIELD(modbus),
      .help = "Where Modbus/TCP is served." },
    { "modbus-allow", "bridges", PEL_OPTION_LIST, "PEERS", "",
      .element = pel_options_network, .offset = FIELD(modbus_allow),
      .help = "Addresses or networks, separated by commas, that may use "
              "Modbus; empty is this machine only." },
    { "modbus-framing", "bridges", PEL_OPTION_CHOICE, "FRAMING", "tcp",
      .choices = framing_words, .offset = FIELD(modbus_framing),
      .help = "How requests come over TCP: as Modbus/TCP, or as RTU with its "
              "CRC, as serial servers pass it on." },
    { "modbus-order", "bridges", PEL_OPTION_CHOICE, "ORDER", "abcd",
      .choices = order_words, .offset = FIELD(modbus_order),
      .help = "Order of the bytes of 32-bit values." },
    { "modbus-units", "bridges", PEL_OPTION_LIST, "any|LIST", "any",
      .offset = FIELD(modbus_units),
      .help = "Units that answer: any is 0, 1 and 255; or a list of "
              "UNIT[:ORDER[:ENTITY[:VIEW]]], each a source of its own." },
    { "modbus-clients", "bridges", PEL_OPTION_INT, "COUNT", "32", 1, 256,
      "clients", .offset = FIELD(modbus_clients),
      .help = "Most Modbus clients at once." },
    { "modbus-heartbeat", "bridges", PEL_OPTION_INT, "MS", "1000", 100, 60000,
      "ms", .offset = FIELD(modbus_heartbeat_ms),
      .help = "Silence of the heartbeat register that makes its source "
              "stale." },
    { "modbus-extrapolate", "bridges", PEL_OPTION_INT, "MS", "5000", 0, 60000,
      "ms", .offset = FIELD(modbus_extrapolate_ms),
      .help = "How long the ship is reckoned on when its source is stale." },
    { "modbus-safe", "bridges", PEL_OPTION_LIST, "PATH=VALUE,…", "",
      .offset = FIELD(modbus_safe),
      .help = "Fields that are set after that, like "
              "views.bridge.yaw=0,views.bridge.pitch=0: a safe view. Views "
              "that it names must be there at the start." },
    { "console", "bridges", PEL_OPTION_TARGET, "HOST:PORT|off", "off",
      .offset = FIELD(console),
      .help = "Modbus/TCP server of a bridge console, whose registers are "
              "polled." },
    { "console-table", "bridges", PEL_OPTION_PATH, "FILE|off", "off",
      .offset = FIELD(console_table),
      .help = "Which registers of the console set which fields." },
    { "console-rate", "bridges", PEL_OPTION_DOUBLE, "HZ", "10", 0.1, 100, "Hz",
      .offset = FIELD(console_rate), .help = "Polls of the console a second." },
    { "console-order", "bridges", PEL_OPTION_CHOICE, "ORDER", "abcd",
      .choices = order_words, .offset = FIELD(console_order),
      .help = "Order of the bytes of the console's 32-bit values." },
    { "console-unit", "bridges", PEL_OPTION_INT, "UNIT", "1", 0, 255, "",
      .offset = FIELD(console_unit), .help = "Unit of the console." },
    { "console-timeout", "bridges", PEL_OPTION_INT, "MS", "500", 10, 10000,
      "ms", .offset = FIELD(console_timeout_ms),
      .help = "How long the console may take to answer." },
    { "console-stale", "bridges", PEL_OPTION_INT, "MS", "2000", 100, 60000,
      "ms", .offset = FIELD(console_stale_ms),
      .help = "Silence of the console that makes it stale." },
    { "nmea", "bridges", PEL_OPTION_ADDRESS, "ADDRESS:PORT|off",
      "127.0.0.1:10110", .offset = FIELD(nmea),
      .help = "UDP port that takes NMEA 0183." },
    { "nmea-tcp", "bridges", PEL_OPTION_ADDRESS, "ADDRESS:PORT|off", "off",
      .offset = FIELD(nmea_tcp),
      .help = "TCP port that takes NMEA 0183; 10110 is customary." },
    { "nmea-allow", "bridges", PEL_OPTION_LIST, "PEERS", "",
      .element = pel_options_network, .offset = FIELD(nmea_allow),
      .help = "Addresses or networks, separated by commas, that may send "
              "NMEA; empty is this machine only." },
    { "nmea-checksum", "bridges", PEL_OPTION_CHOICE, "WHETHER", "required",
      .choices = checksum_words, .offset = FIELD(nmea_checksum),
      .help = "Whether a sentence must have its checksum; optional takes one "
              "that has none. A sentence with a wrong one is dropped." },
    { "nmea-entity", "bridges", PEL_OPTION_INT, "ID", "1", 0, 65535, "",
      .offset = FIELD(nmea_entity),
      .help = "Entity that NMEA sentences move." },
    { "nmea-wind", "bridges", PEL_OPTION_CHOICE, "HOW", "given",
      .choices = wind_words, .offset = FIELD(nmea_wind),
      .help = "Whether true wind sets the sea: not, as given, or its mean "
              "over two minutes." },
    { "nmea-out", "bridges", PEL_OPTION_LIST, "[ENTITY@]HOST:PORT,…", "",
      .element = pel_options_outlet, .offset = FIELD(nmea_out),
      .help = "Where ships are sent as NMEA 0183 over UDP: ENTITY, else "
              "--nmea-entity; names of hosts are looked up again as they "
              "move. Empty or off is nowhere." },
    { "nmea-out-rate", "bridges", PEL_OPTION_DOUBLE, "HZ", "1", 0.1, 50, "Hz",
      .offset = FIELD(nmea_out_rate), .help = "How often it is sent." },
    { "nmea-out-targets", "bridges", PEL_OPTION_CHOICE, "HOW", "off",
      .choices = traffic_words, .offset = FIELD(nmea_out_targets),
      .help = "Whether other entities are sent as well: as a radar's targets "
              "(TTM), as AIS (VDM), as both." },
    { "nmea-ais", "bridges", PEL_OPTION_FLAG, "", "no",
      .offset = FIELD(nmea_ais),
      .help = "Shows AIS and radar targets as entities 20000 and up." },
    { "nmea-targets", "bridges", PEL_OPTION_INT, "COUNT", "100", 100, 2000,
      "targets", .offset = FIELD(nmea_targets),
      .help = "AIS targets that are kept; 100 of them, the nearest to own "
              "ship, are entities, as far as the state has room." },
    { "cigi", "bridges", PEL_OPTION_ADDRESS, "ADDRESS:PORT|off", "off",
      .offset = FIELD(cigi),
      .help = "UDP port that takes CIGI 3.3 of a simulator host; customary is "
              "127.0.0.1:8000." },
    { "cigi-host", "bridges", PEL_OPTION_TARGET, "HOST:PORT|off", "off",
      .offset = FIELD(cigi_host),
      .help = "Where Start of Frame and answers go, from the start on, by "
              "number or name; off is to the host that was heard." },
    { "cigi-allow", "bridges", PEL_OPTION_LIST, "PEERS", "",
      .element = pel_options_network, .offset = FIELD(cigi_allow),
      .help = "Addresses or networks, separated by commas, that may send "
              "CIGI; empty is this machine only." },
    { "cigi-entities", "bridges", PEL_OPTION_PATH, "FILE|off", "off",
      .offset = FIELD(cigi_entities),
      .help = "Which models CIGI's entity types are: lines of a type and a "
              "model, 17 {\"name\": \"tanker\"}." },
    { "cigi-gone", "bridges", PEL_OPTION_CHOICE, "HOW", "resume",
      .choices = gone_words, .offset = FIELD(cigi_gone),
      .help = "When the CIGI host falls silent: clock.mode becomes what it was "
              "before, or time holds." },
    { "cigi-silence", "bridges", PEL_OPTION_DOUBLE, "SECONDS", "2", 0.5, 3600,
      "s", .offset = FIELD(cigi_silence_s),
      .help = "A CIGI host that sends nothing for this long is gone." },
    { "cigi-database", "bridges", PEL_OPTION_INT, "NUMBER", "0", 0, 127, "",
      .offset = FIELD(cigi_database),
      .help = "Database number that a CIGI host may load; 0 is any." },
    { "cigi-rate", "bridges", PEL_OPTION_DOUBLE, "HZ", "60", 1, 240, "Hz",
      .offset = FIELD(cigi_rate),
      .help = "Start of Frame a second, and host frames without timestamps." },

    { "exercise", "nodes", PEL_OPTION_LIST, "URL[,URL...]/NAME|off", "",
      .secret = true, .offset = FIELD(exercise),
      .help = "The exercise that this daemon shows together with others, which "
              "give the same: http://10.0.0.1:2379,http://10.0.0.2:2379/NAME, "
              "where etcd answers. One of them takes the edits, and all show "
              "the same frames (docs/cluster.md)." },
    { "exercise-node", "nodes", PEL_OPTION_TEXT_KIND, "NAME", "",
      .offset = FIELD(exercise_node),
      .help = "Name of this node, another for each; else the machine's." },
    { "exercise-address", "nodes", PEL_OPTION_TEXT_KIND, "ADDRESS", "",
      .offset = FIELD(exercise_address),
      .help = "Where clients reach this node, as it is told to those who send "
              "an edit to another one; else what --http says." },
    { "exercise-rank", "nodes", PEL_OPTION_INT, "RANK", "0", -1, 99, "",
      .offset = FIELD(exercise_rank),
      .help = "Of the nodes that are there the one with the lowest takes over "
              "where the master falls silent; -1 never does." },
    { "exercise-spare", "nodes", PEL_OPTION_FLAG, "", "no",
      .offset = FIELD(exercise_spare),
      .help = "This node is there for those that are gone: it takes the views "
              "that are placed at them (pelagosctl cluster place)." },
    { "exercise-cert", "nodes", PEL_OPTION_PATH, "FILE|off", "off",
      .offset = FIELD(exercise_cert),
      .help = "Certificate in PEM that is shown to etcd." },
    { "exercise-key", "nodes", PEL_OPTION_PATH, "FILE|off", "off",
      .offset = FIELD(exercise_key), .help = "Key of --exercise-cert in PEM." },
    { "exercise-ca", "nodes", PEL_OPTION_PATH, "FILE|off", "off",
      .offset = FIELD(exercise_ca),
      .help = "Certificates in PEM of those who may sign etcd's; else the "
              "system's." },

    { "log-level", "log", PEL_OPTION_CHOICE, "LEVEL", "info",
      .choices = level_words, .live = true, .offset = FIELD(log_level),
      .help = "Records less important than this are not written." },
    { "log-format", "log", PEL_OPTION_CHOICE, "FORM", "auto",
      .choices = form_words, .offset = FIELD(log_format),
      .help = "How a record is written: a line with the time in UTC, an object "
              "of JSON a line, or as journald reads it; auto is journal where "
              "journald reads, else text." },
    { 0 },
};

/* For who works on the drawing itself: no options. */
const struct pel_option pel_developer_table[] = {
    { "PELAGOS_SHADING", "developer", PEL_OPTION_CHOICE, "HOW", "auto",
      .choices = shading_words, .offset = FIELD(shading),
      .help = "Whether pixels are shaded as fragments or in compute, by the "
              "same functions; auto takes fragments on a software device, "
              "compute on hardware." },
    { "PELAGOS_REFLECTION", "developer", PEL_OPTION_CHOICE, "HOW", "drawn",
      .choices = reflection_words, .offset = FIELD(reflection),
      .help = "paper: sky and Sun in the sea by Bruneton et al. 2010 as it "
              "stands, to compare with." },
    { "PELAGOS_SHADER_DIR", "developer", PEL_OPTION_PATH, "DIRECTORY|off",
      "off", .offset = FIELD(shader_dir),
      .help = "Reads the shaders from here instead of the built-in ones." },
    { "PELAGOS_GL_DEBUG", "developer", PEL_OPTION_FLAG, "yes|no", "no",
      .offset = FIELD(gl_debug),
      .help = "Sends the OpenGL driver's messages to the log." },
    { "PELAGOS_GL_LOSE", "developer", PEL_OPTION_INT, "COUNT", "0", 0, 1000000,
      "pictures", .offset = FIELD(gl_lose),
      .help = "Pretends that the device is lost after so many pictures; 0: "
              "never." },
    { "PELAGOS_GL_LOSE_DEVICE", "developer", PEL_OPTION_INT, "INDEX", "-1", -1,
      15, "of the list of devices", .offset = FIELD(gl_lose_device),
      .help = "Pretends so of this device alone; -1: of all." },
    { "PELAGOS_GL_LOSE_FOR_GOOD", "developer", PEL_OPTION_FLAG, "yes|no", "no",
      .offset = FIELD(gl_lose_for_good),
      .help = "Pretends that a device so lost cannot be had again." },
    { "PELAGOS_EXERCISE_STRAY", "developer", PEL_OPTION_INT, "FRAME", "0", 0,
      1000000000, "", .offset = FIELD(exercise_stray),
      .help = "Makes this node's state another one before the first frame of "
              "an exercise that it plays from this one on, once; 0: never." },
    { "PELAGOS_EXERCISE_CLOCK", "developer", PEL_OPTION_DOUBLE, "MS", "0",
      -10000, 10000, "ms", .offset = FIELD(exercise_clock_ms),
      .help = "Pretends that this node's clock is so much ahead of the "
              "machine's, for what it tells the others of an exercise." },
    { 0 },
};
