# Pelagos. `make help` lists the targets; V=1 shows commands; DEV=1 turns
# warnings into errors; FLAVOR=asan|tsan|fuzz builds beside the release.
# Objects of other flags are other objects (build/FLAVOR/obj-KEY).

.DEFAULT_GOAL := all
SHELL := /bin/bash
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules

# Of everything: programs, library, packages, Python's client.
VERSION := $(strip $(file <VERSION))
PREFIX ?= /usr/local
FLAVOR ?= release
O := build/$(FLAVOR)
Q := $(if $(V),,@)

# --- packages -------------------------------------------------------------
# Debian 12 names, in one place: `make deps` installs them, tests/ needs more.
BUILD_PACKAGES := gcc libc6-dev make pkg-config python3 python3-protobuf \
    protobuf-compiler protobuf-c-compiler libprotobuf-c-dev libglib2.0-dev \
    libepoxy-dev libegl-dev libgl-dev libegl1 libegl-mesa0 libgl1-mesa-dri \
    glslang-tools libmicrohttpd-dev libmodbus-dev \
    libjpeg62-turbo-dev libturbojpeg0-dev libspng-dev libopenexr-dev libsystemd-dev \
    libgstreamer1.0-dev libgstreamer-plugins-base1.0-dev \
    gstreamer1.0-plugins-base gstreamer1.0-plugins-good \
    gstreamer1.0-plugins-bad gstreamer1.0-plugins-ugly gstreamer1.0-nice \
    libgstreamer-plugins-bad1.0-dev \
    libgstrtspserver-1.0-dev libwslay-dev libyuv-dev \
    libcurl4-openssl-dev libnova-dev libssl-dev libgdal-dev libhdf5-dev libnetcdf-dev libeccodes-dev libassimp-dev
# What `make site` is made by.
SITE_PACKAGES := python3-sphinx python3-myst-parser furo graphviz groff
# What `make deb` is made by.
DEB_PACKAGES := dpkg-dev debhelper dh-python lintian python3-pip python3-setuptools \
    python3-wheel
TEST_PACKAGES := gmt-gshhg-low gstreamer1.0-tools glib-networking gdal-bin gpsd-clients libcmocka-dev curl jq libeccodes-tools ffmpeg mbpoll python3-pymodbus \
    libimage-exiftool-perl netcdf-bin python3-netcdf4 python3-xarray librsvg2-bin \
    python3-serial-asyncio python3-jsonschema python3-hypothesis \
    xplanet python3-numpy python3-pil python3-pip python3-setuptools python3-venv \
    python3-wheel openexr chromium \
    slurm-wlm munge nginx-light haproxy openssl mypy clang \
    libclang-rt-14-dev clang-tidy clang-format man-db systemd \
    tshark python3-yaml iproute2 nftables etcd-server etcd-client python3-gi gir1.2-gst-plugins-bad-1.0 coturn $(SITE_PACKAGES) $(DEB_PACKAGES) \
    python3-nbclient python3-ipykernel python3-matplotlib \
    python3-pyqt5.qtwebengine xvfb xauth \
    colcon python3-colcon-ros python3-ament-package python3-genmsg python3-nav-msgs \
    python3-rosgraph-msgs python3-sensor-msgs python3-tf2-msgs
# Players that `make players` tries; nothing else needs these 323 MB.
PLAYER_PACKAGES := python3-opencv mpv vlc-bin vlc-plugin-base
# Of npm's registry, into build/npm: clients that tests speak to, what drives
# Debian's Chromium, what judges the page.
NPM_PACKAGES := modbus-serial@8.0.25 playwright-core@1.49.1 axe-core@4.10.2 \
    @seriousme/openapi-schema-validator@2.11.0 \
    acorn@8.14.0 acorn-walk@8.3.4 css-tree@3.1.0 @mdn/browser-compat-data@6.0.0 \
    openapi-typescript@7.4.4 openapi-fetch@0.13.3 typescript@5.6.3 \
    openapi-typescript-codegen@0.31.0 \
    hyparquet@1.33.0 parquet-wasm@0.8.0 apache-arrow@21.2.0
# Of the same, embedded in the page and loaded when its sea-state card is
# opened. A tarball of `make dist` brings it along.
PAGE_PACKAGES := uplot@1.6.32 hls.js@1.6.15
THIRD ?= $(firstword $(wildcard third-party) build/npm-page/node_modules)
# As the page calls them, and where they lie in THIRD.
EMBEDDED := uplot.js=uplot/dist/uPlot.iife.min.js uplot.css=uplot/dist/uPlot.min.css \
    uplot.txt=uplot/LICENSE hls.js=hls.js/dist/hls.light.min.js hls.txt=hls.js/LICENSE

PKGS := glib-2.0 gio-unix-2.0 epoxy libmicrohttpd \
    libprotobuf-c libmodbus libjpeg libturbojpeg spng OpenEXR libsystemd openssl libcurl \
    gstreamer-1.0 gstreamer-app-1.0 gstreamer-video-1.0 \
    gstreamer-rtsp-server-1.0 gstreamer-rtsp-1.0 \
    gstreamer-webrtc-1.0 gstreamer-sdp-1.0

# --- flags ----------------------------------------------------------------
CC := gcc
WARN := -Wno-psabi -Wall -Wextra -Wshadow -Wstrict-prototypes -Wmissing-prototypes \
    -Wpointer-arith -Wvla -Wformat=2 -Wno-format-nonliteral -Wundef \
    -Wunused-result $(if $(DEV),-Werror)
OPT_release := -O2 -g
OPT_asan := -O1 -g -fsanitize=address,undefined -fno-omit-frame-pointer
OPT_tsan := -O2 -g -fsanitize=thread
# GLib built for the checker (packaging/tsan_glib.sh), of the libraries too.
LINK_tsan = -Wl,--disable-new-dtags,-rpath,$(TSAN_GLIB)/lib
TSAN_GLIB = $(CURDIR)/build/tsan/glib
OPT_fuzz := -O1 -g -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined
OPT_cover := -O1 -g -fsanitize=fuzzer-no-link -fprofile-instr-generate -fcoverage-mapping
ifneq ($(filter fuzz cover,$(FLAVOR)),)
CC := clang
endif
OPT := $(OPT_$(FLAVOR))
OUR_CPPFLAGS := -Iserver -Iproto -Iclients -I. -I$(O)/gen -D_GNU_SOURCE \
    -DPEL_VERSION='"$(VERSION)"'
# No contraction and no fast-math: the same bits whatever the optimiser does.
OUR_CFLAGS := -std=c17 $(OPT) $(WARN) -ffp-contract=off -fvisibility=hidden -pthread
# Asked once, and only when something is compiled: pkg-config may not be there
# before `make deps` has run.
PKG_CFLAGS = $(eval PKG_CFLAGS := $(shell pkg-config --cflags $(PKGS)))$(PKG_CFLAGS)
PKG_LIBS = $(eval PKG_LIBS := $(shell pkg-config --libs $(PKGS)) -lOpenEXRCore -lyuv -lwslay -lnova -lm)$(PKG_LIBS)
# GStreamer muxes what pelagosctl records; the daemon does not link it.
CTL_PKGS := gstreamer-1.0 gstreamer-app-1.0
READER_PKGS := gdal hdf5-serial OpenEXR
SPECTRUM_PKGS := netcdf
WEATHER_PKGS := eccodes netcdf hdf5-serial
MODEL_PKGS := assimp spng libjpeg
# As a system header: it is not clean of our warnings.
READER_CFLAGS = $(eval READER_CFLAGS := $(patsubst -I%,-isystem %,$(shell pkg-config --cflags $(READER_PKGS))))$(READER_CFLAGS)
READER_LIBS = $(eval READER_LIBS := $(shell pkg-config --libs $(READER_PKGS)) -lOpenEXRCore -lm)$(READER_LIBS)
SPECTRUM_LIBS = $(eval SPECTRUM_LIBS := $(shell pkg-config --libs $(SPECTRUM_PKGS)))$(SPECTRUM_LIBS)
WEATHER_CFLAGS = $(eval WEATHER_CFLAGS := $(patsubst -I%,-isystem %,$(shell pkg-config --cflags hdf5-serial)))$(WEATHER_CFLAGS)
WEATHER_LIBS = $(eval WEATHER_LIBS := $(shell pkg-config --libs $(WEATHER_PKGS)) -lm)$(WEATHER_LIBS)
MODEL_CFLAGS = $(eval MODEL_CFLAGS := $(patsubst -I%,-isystem %,$(shell pkg-config --cflags $(MODEL_PKGS))))$(MODEL_CFLAGS)
MODEL_LIBS = $(eval MODEL_LIBS := $(shell pkg-config --libs $(MODEL_PKGS)) -lm)$(MODEL_LIBS)
CTL_CFLAGS = $(eval CTL_CFLAGS := $(shell pkg-config --cflags $(CTL_PKGS)))$(CTL_CFLAGS)
CTL_LIBS = $(eval CTL_LIBS := $(shell pkg-config --libs $(CTL_PKGS)))$(CTL_LIBS)

# --- sources, by room -----------------------------------------------------
# All of a directory, but its tests and programs of their own.
APART := %_test.c %_doc.c $(addprefix clients/lib/,example.c save_live.c sense.c)
room = $(filter-out $(APART),$(sort $(wildcard $(1)/*.c)))
BASE := $(call room,server/base)
OCEAN := $(call room,server/ocean)
SEABED := $(call room,server/seabed)
MODELS := $(call room,server/models)
PANORAMA := $(call room,server/panorama)
CONTINENTS := $(call room,server/continents)
WEATHER := $(call room,server/weather)
OPTICS := $(call room,server/optics)
PROTO := $(call room,proto)
SCENE := $(call room,server/scene)
RENDER := $(call room,server/render)
ENCODE := $(call room,server/encode)
FRAMES := $(call room,server/frames)
NET := $(call room,server/net)
BRIDGES := $(call room,server/bridges)
CLUSTER := $(call room,server/cluster)
# Programs of their own: GDAL, ecCodes and assimp are not the daemon's.
SEABED_READER := $(call room,server/seabed/reader)
MODEL_READER := $(call room,server/models/reader)
PANORAMA_READER := $(call room,server/panorama/reader)
SPECTRUM_READER := $(call room,server/ocean/reader)
CONTINENTS_READER := $(call room,server/continents/reader)
# With what both that read HDF5 need.
WEATHER_READER := $(call room,server/weather/reader) server/seabed/reader/hdf5.c
DAEMON := server/main.c server/service.c
# What makes tables of the server while it is built, and which (pel_NAME).
MAKER := server/tables.c
MADE := clear_air foam_grain colour_suns
OPTIONS := $(filter-out $(DAEMON) $(MAKER),$(call room,server))
CLIENT := $(call room,clients/lib)
CTL := $(call room,clients/pelagosctl)
PAGES := $(wildcard clients/web/*.html clients/web/*.css clients/web/*.js \
    clients/web/*.json clients/web/*.svg)
TESTS := $(sort $(wildcard proto/*_test.c server/*_test.c server/*/*_test.c \
    clients/*/*_test.c tests/*/*_test.c tests/validate/*/*_test.c))

# Fuzz targets (libFuzzer), each with LLVMFuzzerTestOneInput.
FUZZERS := $(sort $(wildcard tests/fuzz/fuzz_*.c))

# --- flags of one source --------------------------------------------------
# Vectors throughout; square roots of what is never negative.
VECTORS := -O3 -fno-math-errno
FLAGS_server/ocean/fft := $(VECTORS)
FLAGS_server/ocean/evolve := $(VECTORS)
FLAGS_server/ocean/wake := $(VECTORS)
FLAGS_server/ocean/wakebasin := $(VECTORS)
FLAGS_server/optics/airlight := $(VECTORS)
FLAGS_server/optics/airrays := $(VECTORS)
FLAGS_clients/pelagosctl/clip = $(CTL_CFLAGS)
FLAGS_clients/pelagosctl/clip_stream = $(CTL_CFLAGS)
$(foreach f,$(SEABED_READER:.c=) tests/any_raster,$(eval FLAGS_$(f) = $$(READER_CFLAGS)))
$(foreach f,$(filter server/weather/%,$(WEATHER_READER:.c=)),$(eval FLAGS_$(f) = $$(WEATHER_CFLAGS)))
$(foreach f,$(MODEL_READER:.c=),$(eval FLAGS_$(f) = $$(MODEL_CFLAGS)))
FLAGS_tests/fuzz/fuzz_forecast = $(WEATHER_CFLAGS)
$(foreach f,raster picture,$(eval FLAGS_tests/fuzz/fuzz_$(f) = $$(READER_CFLAGS) $$(MODEL_CFLAGS)))
$(foreach f,$(basename $(wildcard tests/validate/*.c tests/validate/seatrace/*.c tests/validate/airtrace/*.c tests/validate/shiptrace/*.c tests/validate/undertrace/*.c tests/validate/spacetrace/*.c)),$(eval FLAGS_$(f) := -O3))
# Arithmetic on memory of one caller and who helps him; watched, a picture in new air
# takes minutes. Who calls it, and from which threads, is watched.
UNWATCHED_tsan := server/ocean/fft server/ocean/evolve server/optics/airrays server/optics/linear
$(foreach f,$(UNWATCHED_$(FLAVOR)),$(eval FLAGS_$(f) += -fno-sanitize=thread))
# CPPFLAGS, CFLAGS and LDFLAGS are the caller's, and come last.
compile = $(CC) $(OUR_CPPFLAGS) $(PKG_CFLAGS) $(OUR_CFLAGS) $(FLAGS_$(1)) $(CPPFLAGS) $(CFLAGS)

# What decides about an object beside its sources.
quoted = '$(subst ','\'',$(1))'
KEY := $(shell printf %s $(call quoted,$(CC) $(OUR_CPPFLAGS) $(OUR_CFLAGS) $(CPPFLAGS) $(CFLAGS) $(LDFLAGS)$(LINK_$(FLAVOR)) $(VECTORS) \
    $(PKGS) $(CTL_PKGS) $(READER_PKGS) $(SPECTRUM_PKGS) $(WEATHER_PKGS) $(MODEL_PKGS)) | sha1sum | cut -c 1-10)
OBJ := $(O)/obj-$(KEY)

# --- rules ----------------------------------------------------------------
SERVER := $(BASE) $(OCEAN) $(SEABED) $(MODELS) $(PANORAMA) $(CONTINENTS) $(WEATHER) $(OPTICS) $(PROTO) $(SCENE) $(RENDER) $(ENCODE) \
    $(FRAMES) $(CLUSTER) $(NET) $(BRIDGES) $(OPTIONS)
GEN := $(O)/gen/pelagos.pb-c.c $(O)/gen/fields.c $(O)/gen/shaders.c \
    $(O)/gen/pages.c
GEN_HEADERS := $(O)/gen/pelagos.pb-c.h
obj = $(patsubst %.c,$(OBJ)/%.o,$(1))
SERVER_OBJ := $(call obj,$(SERVER)) $(patsubst $(O)/%.c,$(OBJ)/%.o,$(GEN)) $(MADE:%=$(OBJ)/gen/%.o)
CLIENT_OBJ := $(call obj,$(CLIENT))
CTL_OBJ := $(call obj,$(CTL))
CTL_MAIN := $(OBJ)/clients/pelagosctl/pelagosctl.o
TEST_BIN := $(patsubst %.c,$(O)/bin/%,$(notdir $(TESTS)))
fuzz_bin := $(patsubst %.c,$(O)/bin/%,$(notdir $(FUZZERS)))
SHADERS := $(wildcard shaders/*.vert shaders/*.frag shaders/*.comp shaders/lib/*.glsl shaders/lib/*.h) proto/layers.def proto/deffile.py

# build/NAME leads to the release; other flavours stay in build/FLAVOR/bin.
PROGRAMS := $(addprefix $(if $(filter release,$(FLAVOR)),build,$(O)/bin)/,\
    pelagosd pelagosctl pelagos-seabed pelagos-model pelagos-panorama pelagos-spectrum pelagos-continents pelagos-weather pelagos-plot pelagos-dataset)

.PHONY: all
all: $(PROGRAMS) ## build the daemon and its command line

build/%: $(O)/bin/%
	$(Q)mkdir -p $(@D) && ln -sf $(FLAVOR)/bin/$* $@

# Programs take of the libraries what they use. They lie in one place whatever
# the flags: other flags link them anew.
define LINK
$(Q)mkdir -p $(@D)
@echo "  LINK  $@"
$(Q)$(CC) $(OPT) $(CFLAGS) $(LDFLAGS) $(LINK_$(FLAVOR)) -pthread -Wl,--as-needed -o $@ $(filter %.o %.a,$^)
endef
$(O)/flags: FORCE
	$(Q)mkdir -p $(@D); [ "$$(cat $@ 2>/dev/null)" = $(KEY) ] || echo $(KEY) >$@
.PHONY: FORCE
$(TEST_BIN) $(fuzz_bin) $(addprefix $(O)/bin/,pelagosd pelagosd-starved pelagosctl \
    pelagos-seabed pelagos-model pelagos-panorama pelagos-spectrum pelagos-continents pelagos-weather drawmodel registers_doc cigi_doc nmea_doc bench still bench_streams \
    bench_devices any_raster rhythm validate_water seatrace airtrace airours shiptrace undertrace spacetrace cloudtrace): $(O)/flags \
    $(if $(filter asan,$(FLAVOR)),$(OBJ)/tests/lib/loading.o)

$(O)/bin/pelagosd: $(call obj,$(DAEMON)) $(OBJ)/libserver.a
	$(LINK) $(PKG_LIBS)

# The daemon where memory that our own code asks for is refused at chosen calls.
STARVED := malloc calloc realloc aligned_alloc posix_memalign strdup strndup
$(O)/bin/pelagosd-starved: $(call obj,$(DAEMON)) $(OBJ)/tests/lib/starve.o $(OBJ)/libserver.a
	$(LINK) $(addprefix -Wl$(comma)--wrap=,$(STARVED)) $(PKG_LIBS)

$(O)/bin/pelagos-seabed: $(call obj,$(SEABED_READER)) $(OBJ)/libserver.a
	$(LINK) $(READER_LIBS)

$(O)/bin/pelagos-weather: $(call obj,$(WEATHER_READER)) $(OBJ)/libserver.a
	$(LINK) $(WEATHER_LIBS)

$(O)/bin/pelagos-model: $(call obj,$(MODEL_READER)) $(OBJ)/libserver.a
	$(LINK) $(MODEL_LIBS)

$(O)/bin/pelagos-spectrum: $(call obj,$(SPECTRUM_READER)) $(OBJ)/libserver.a
	$(LINK) $(SPECTRUM_LIBS) -lm

$(O)/bin/pelagos-continents: $(call obj,$(CONTINENTS_READER)) $(OBJ)/libserver.a
	$(LINK) $(SPECTRUM_LIBS) -lm

# For pelagosctl plot and dataset, out of the tree; installed, they are the
# Python package's.
$(O)/bin/pelagos-plot $(O)/bin/pelagos-dataset: $(O)/bin/pelagos-%: Makefile
	$(Q)mkdir -p $(@D)
	$(Q)printf '%s\n' '#!/bin/sh' 'PYTHONPATH="$(CURDIR)/clients/python" exec /usr/bin/python3 -m pelagos.$* "$$@"' >$@
	$(Q)chmod +x $@

$(O)/bin/pelagos-panorama: $(call obj,$(PANORAMA_READER)) $(OBJ)/libserver.a
	$(LINK) -lOpenEXRCore -lm

$(O)/bin/pelagosctl: $(CTL_MAIN) $(OBJ)/libctl.a $(OBJ)/libpelagos.a $(OBJ)/libserver.a
	$(LINK) $(PKG_LIBS) $(CTL_LIBS)

# Tables that take a core long to make, as they are in memory.
$(OBJ)/libtables.a: $(call obj,$(OPTICS) $(BASE) server/ocean/foamgrain.c)
	$(Q)rm -f $@ && ar rcs $@ $^

$(OBJ)/tables: $(call obj,$(MAKER)) $(OBJ)/libtables.a
	$(Q)$(CC) $(OPT) $(CFLAGS) $(LDFLAGS) -o $@ $^ -lm

$(MADE:%=$(OBJ)/gen/%.o): $(OBJ)/gen/%.o: $(OBJ)/tables
	@echo "  GEN   $@"
	$(Q)mkdir -p $(@D) && $< $* $(@:.o=.bin)
	$(Q)printf '%s\n' '.section .rodata' '.globl pel_$*' '.balign 64' \
	    '.type pel_$*, @object' 'pel_$*: .incbin "$(@:.o=.bin)"' \
	    '.size pel_$*, . - pel_$*' \
	    '.section .note.GNU-stack, "", @progbits' | $(CC) -c -x assembler -o $@ -

$(OBJ)/libserver.a: $(SERVER_OBJ)
	$(Q)rm -f $@ && ar rcs $@ $^

# Whole by itself: with the messages and the framing, without the server.
$(OBJ)/libpelagos.a: $(CLIENT_OBJ) $(OBJ)/gen/pelagos.pb-c.o $(OBJ)/proto/wire.o $(OBJ)/server/base/reserve.o
	$(Q)rm -f $@ && ar rcs $@ $^

$(O)/libpelagos.a: $(OBJ)/libpelagos.a $(O)/flags
	$(Q)cp $< $@

# The same to share. Its ABI is the messages', so each minor version has its own
# soname and symbol version; what is exported is what the public headers declare.
ABI := $(basename $(VERSION))
SHARED := libpelagos.so.$(VERSION)
PUBLIC := clients/lib/pelagos.h $(O)/gen/pelagos.pb-c.h
PIC_OBJ := $(patsubst $(OBJ)/%,$(OBJ)/pic/%,$(CLIENT_OBJ) $(OBJ)/gen/pelagos.pb-c.o \
    $(OBJ)/proto/wire.o $(OBJ)/server/base/reserve.o)

$(OBJ)/pic/%.o: %.c | $(GEN_HEADERS)
	$(Q)mkdir -p $(@D)
	$(Q)$(call compile,$*) -fPIC -MMD -MP -c -o $@ $<

$(OBJ)/pic/gen/%.o: $(O)/gen/%.c | $(GEN_HEADERS)
	$(Q)mkdir -p $(@D)
	$(Q)$(call compile,) -w -fPIC -fvisibility=default -MMD -MP -c -o $@ $<

$(O)/gen/libpelagos.map: clients/lib/exports.py $(PUBLIC) VERSION
	$(Q)/usr/bin/python3 $< PELAGOS_$(ABI) $(PUBLIC) >$@

$(O)/$(SHARED): $(PIC_OBJ) $(O)/gen/libpelagos.map $(O)/flags
	@echo "  LINK  $@"
	$(Q)$(CC) $(OPT) $(CFLAGS) $(LDFLAGS) -pthread -shared -o $@ $(PIC_OBJ) \
	    -Wl,-soname,libpelagos.so.$(ABI) -Wl,--as-needed -Wl,--no-undefined \
	    -Wl,--version-script=$(O)/gen/libpelagos.map \
	    -Wl,--no-undefined-version $$(pkg-config --libs libprotobuf-c openssl)

$(OBJ)/libctl.a: $(filter-out $(CTL_MAIN),$(CTL_OBJ))
	$(Q)rm -f $@ && ar rcs $@ $^

# Names every missing library at once, before the compiler stumbles over one.
$(O)/gen/packages: Makefile
	$(Q)mkdir -p $(@D)
	$(Q)missing=; for p in $(PKGS) $(CTL_PKGS) $(READER_PKGS) $(SPECTRUM_PKGS) $(WEATHER_PKGS) $(MODEL_PKGS); do \
	    pkg-config --exists $$p 2>/dev/null || missing="$$missing $$p"; done; \
	for c in protoc protoc-c glslangValidator; do \
	    command -v $$c >/dev/null || missing="$$missing $$c"; done; \
	if [ "$$missing" ]; then echo "missing:$$missing"; \
	    echo "run \`make deps\` (Debian 12), or install them by hand"; exit 1; fi
	$(Q)touch $@

$(OBJ)/%.o: %.c | $(GEN_HEADERS)
	$(Q)mkdir -p $(@D)
	@echo "  CC    $<"
	$(Q)$(call compile,$*) -MMD -MP -c -o $@ $<

$(OBJ)/gen/%.o: $(O)/gen/%.c | $(GEN_HEADERS)
	$(Q)mkdir -p $(@D)
	@echo "  CC    $<"
	$(Q)$(call compile,) -w -MMD -MP -c -o $@ $<

$(O)/gen/pelagos.pb-c.c: proto/pelagos.proto | $(O)/gen/packages
	$(Q)mkdir -p $(@D)
	@echo "  GEN   $@"
	$(Q)protoc --proto_path=proto --c_out=$(@D) $<
$(O)/gen/pelagos.pb-c.h: $(O)/gen/pelagos.pb-c.c ;

$(O)/gen/fields.c: proto/pelagos.proto proto/fields.py
	$(Q)mkdir -p $(@D)
	@echo "  GEN   $@"
	$(Q)/usr/bin/python3 proto/fields.py c $< $@

$(O)/gen/openapi.json: proto/openapi.py proto/fields.py proto/deffile.py \
    proto/pelagos.proto proto/routes.def proto/formats.def VERSION
	$(Q)mkdir -p $(@D)
	@echo "  GEN   $@"
	$(Q)/usr/bin/python3 proto/openapi.py proto/pelagos.proto $(VERSION) $@

# Which of them there are.
$(O)/gen/embedded: FORCE
	$(Q)mkdir -p $(@D)
	$(Q)packaging/embedded.sh $(THIRD) $@ $(EMBEDDED)

$(O)/gen/pages.c: clients/web/embed.py proto/pelagos.proto $(O)/gen/openapi.json $(PAGES) \
    $(O)/gen/embedded
	$(Q)mkdir -p $(@D)
	@echo "  GEN   $@"
	$(Q)/usr/bin/python3 clients/web/embed.py $@ proto/pelagos.proto $(O)/gen/openapi.json $(PAGES) \
	    $$(cut -d' ' -f1 $(O)/gen/embedded)

$(O)/gen/shaders.c: shaders/embed.py $(SHADERS)
	$(Q)mkdir -p $(@D)
	@echo "  GEN   $@"
	$(Q)/usr/bin/python3 shaders/embed.py $@ $(filter-out shaders/lib/% proto/%,$(SHADERS))

.PHONY: manual
manual: ## write proto/manual.md and the Python classes from the schema
	$(Q)/usr/bin/python3 proto/fields.py manual proto/pelagos.proto \
	    proto/manual.md proto/manual.in.md
	$(Q)/usr/bin/python3 proto/fields.py python proto/pelagos.proto \
	    clients/python/pelagos/schema.py $(VERSION)

# A test is one program beside its source: build/<flavor>/bin/NAME_test.
define test_rule
$(O)/bin/$(basename $(notdir $(1))): $(call obj,$(1)) $(OBJ)/libctl.a $(OBJ)/libpelagos.a $(OBJ)/libserver.a
	$$(LINK) $$(PKG_LIBS) $$(CTL_LIBS) -lcmocka
endef
$(foreach t,$(TESTS),$(eval $(call test_rule,$(t))))
$(O)/bin/ground_test: | $(O)/bin/pelagos-seabed
$(O)/bin/continents_test $(O)/bin/space_drawn_test: | $(O)/bin/pelagos-continents

# Every driver of GDAL, for files that the reader must not read.
$(O)/bin/any_raster: $(OBJ)/tests/any_raster.o $(OBJ)/libserver.a
	$(LINK) $(READER_LIBS)

# What characters of light show at each frame.
$(O)/bin/rhythm: $(OBJ)/tests/rhythm.o $(OBJ)/libserver.a
	$(LINK) -lm

# Models for a contact sheet, by a rasteriser of the tests' own.
$(O)/bin/drawmodel: $(OBJ)/tests/models/drawmodel.o $(OBJ)/libserver.a
	$(LINK) $(PKG_LIBS)

.PHONY: models-sheet
models-sheet: deps-build ## every built-in model (or ARGS='FILE …') on one sheet: build/models.png
	$(Q)$(MAKE) -s --no-print-directory $(O)/bin/drawmodel
	$(Q)/usr/bin/python3 -B tests/models/sheet.py $(ARGS)

.PHONY: models-check
models-check: deps-build ## read every model file below DIR, and say what came of each
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/models/checkall.py $(DIR)

# A manual with a table is what its program makes of its text.
TABLE_MANUALS := registers cigi nmea

.PHONY: tests
tests: $(TEST_BIN) $(TABLE_MANUALS:%=$(O)/bin/%_doc) \
    $(O)/bin/pelagosd-starved $(O)/bin/any_raster $(O)/bin/rhythm $(O)/bin/drawmodel $(O)/bin/validate_water $(O)/bin/seatrace $(O)/bin/shiptrace $(O)/bin/airtrace \
    $(O)/bin/airours $(O)/bin/undertrace $(O)/bin/spacetrace $(O)/bin/cloudtrace $(O)/libpelagos.a $(O)/$(SHARED) \
    build/compile_commands.json ## build the test programs

.PHONY: unit
unit: $(TEST_BIN) ## run the C test programs
	$(Q)for t in $(TEST_BIN); do echo "== $$t"; $$t || exit 1; done

.PHONY: golden
golden: $(O)/bin/golden_test ## draw the golden pictures anew; look at each of them
	$(Q)$< --write

$(O)/bin/registers_doc: $(OBJ)/proto/registers_doc.o $(OBJ)/libserver.a
$(O)/bin/cigi_doc: $(OBJ)/server/bridges/cigi_doc.o $(OBJ)/libserver.a
$(O)/bin/nmea_doc: $(OBJ)/server/bridges/nmea_doc.o $(OBJ)/libserver.a
$(TABLE_MANUALS:%=$(O)/bin/%_doc):
	$(LINK) $(PKG_LIBS)

.PHONY: $(TABLE_MANUALS)
registers: ## write proto/registers.md, the Modbus map for people
cigi: ## write proto/cigi.md, the CIGI conformance table
nmea: ## write proto/nmea.md, the NMEA manual with its sentences
$(TABLE_MANUALS): %: $(O)/bin/%_doc
	$(Q)$< <proto/$@.in.md >proto/$@.md

# --- set-up, demonstration, checks ---------------------------------------
.PHONY: deps deps-build deps-page
deps: ## install what building and testing need: Debian packages, npm clients
	$(Q)packaging/deps.sh $(BUILD_PACKAGES) $(TEST_PACKAGES)
	$(Q)packaging/npm.sh build/npm $(NPM_PACKAGES)
	$(Q)packaging/npm.sh build/npm-page $(PAGE_PACKAGES)

deps-build: deps-page
	$(Q)packaging/deps.sh $(BUILD_PACKAGES)

deps-page: ## fetch what the page is built with from npm's registry
	$(Q)packaging/npm.sh build/npm-page $(PAGE_PACKAGES)

.PHONY: players
players: deps ## play the streams with OpenCV, mpv and VLC, and compare pictures
	$(Q)packaging/deps.sh $(PLAYER_PACKAGES)
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/players_test.py

.PHONY: demo
demo: deps-build ## build, sail a short voyage, leave pictures in build/demo/
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B clients/demo/demo.py

.PHONY: bridge
bridge: deps-build ## five windows of a bridge, 225 degrees: build/bridge/panorama.png
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)clients/demo/bridge.sh $(ARGS)

.PHONY: run
run: deps-build ## build and keep pelagosd running (ARGS='--http …')
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)mkdir -p build/recordings
	build/pelagosd --recordings build/recordings $(ARGS)

.PHONY: check
check: deps ## build, then lint, every test and the quick form of validate
	$(Q)$(MAKE) -s --no-print-directory -j$$(nproc) all tests
	$(Q)tests/run $(TEST_BIN) $(E2E) $(LINT)

# Executable scripts only: what they share is not executable.
E2E = $(shell find tests -maxdepth 1 -type f -perm -u+x \( -name '*.sh' -o -name '*.py' -o -name '*.mjs' -o -name '*_test' \) | sort)

.PHONY: cluster-check
cluster-check: deps ## one exercise on machines in namespaces: losses, kills, cuts (root; ARGS='--kills 5 …')
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/cluster/history.py
	$(Q)/usr/bin/python3 -B tests/cluster/check.py $(ARGS)

.PHONY: mutate
mutate: deps ## break MUTANTS (200) lines at random, see which tests notice (SEED=1 ROOMS='ocean …')
	$(Q)tests/mutate --mutants $(or $(MUTANTS),200) --seed $(or $(SEED),1) $(ROOMS)

# Of the end-to-end tests those that start programs of the build, less those that
# ask about the release: which libraries it needs, what the README says of it.
E2E_OF_BUILD = $(filter-out tests/build_test.sh tests/readme_test.py,\
    $(shell grep -lE 'pelagos_daemon|PELAGOS_BIN' $(E2E)))
.PHONY: asan
asan: deps ## every test of our programs under ASan, UBSan and LSan (TESTED='…': those)
	$(Q)$(MAKE) -s --no-print-directory FLAVOR=asan all tests
	$(Q)tests/sanitized asan $(or $(TESTED),$(patsubst $(O)/%,build/asan/%,$(TEST_BIN)) $(E2E_OF_BUILD))

.PHONY: tsan
tsan: deps ## the same under ThreadSanitizer, beside a GLib built for it
	$(Q)packaging/tsan_glib.sh $(TSAN_GLIB)
	$(Q)$(MAKE) -s --no-print-directory FLAVOR=tsan all tests
	$(Q)tests/sanitized tsan $(or $(TESTED),$(patsubst $(O)/%,build/tsan/%,$(TEST_BIN)) $(E2E_OF_BUILD))

comma := ,

# --- benchmarks -----------------------------------------------------------
# Few libraries, so that bench can be carried to a machine without packages.
BENCH_LIBS := -lepoxy -lspng -ljpeg -lturbojpeg -lyuv -lOpenEXRCore -l:libnova.a -lm
BENCH_BIN := $(O)/bin/bench $(O)/bin/still
$(BENCH_BIN): $(O)/bin/%: $(OBJ)/tests/bench/%.o $(OBJ)/tests/bench/fleet.o $(OBJ)/tests/bench/scene.o $(OBJ)/libserver.a
	$(LINK) $(BENCH_LIBS)

$(O)/bin/bench_devices: $(OBJ)/tests/bench/devices.o $(OBJ)/libserver.a
	$(LINK) $(PKG_LIBS)

$(O)/bin/bench_streams: $(OBJ)/tests/bench/streams.o $(OBJ)/tests/bench/scene.o $(OBJ)/libserver.a
	$(LINK) $(PKG_LIBS)

.PHONY: bench-streams
bench-streams: deps ## what streams cost, and their latency in Chromium
	$(Q)$(MAKE) -s --no-print-directory all $(O)/bin/bench_streams
	$(O)/bin/bench_streams $(or $(ARGS),--views 1$(comma)4)
	$(Q)node tests/bench/latency.mjs
	$(Q)/usr/bin/python3 -B tests/stream_test.py Crowd \
	    Rtsp.test_late_joiner_gets_a_key_frame_after_play

.PHONY: bench-devices
bench-devices: deps-build ## what several devices draw together (ARGS='--views 64 0 0,1')
	$(Q)$(MAKE) -s --no-print-directory $(O)/bin/bench_devices
	$(O)/bin/bench_devices $(or $(ARGS),--views 8 --size 320x180 software software$(comma)software)

.PHONY: bench
bench: deps-build ## time frames, views, queries, encoders, streams (ARGS='--quick …')
	$(Q)$(MAKE) -s --no-print-directory $(BENCH_BIN) $(O)/bin/bench_streams
	$(O)/bin/bench $(ARGS)
	$(O)/bin/bench_streams --views 1 --seconds 2

# Prints how to run it elsewhere where this machine has no GPU.
GPU_CHECK := build/gpu-check.tar.xz
.PHONY: gpu-check
gpu-check: deps-build ## renderer tests, goldens, frame times on a GPU (PARENT=DIR: another build's programs, in turns)
	$(Q)$(MAKE) -s --no-print-directory tests $(O)/bin/still
	$(Q)tests/gpu/pack.py $(if $(PARENT),--parent $(PARENT)) $(GPU_CHECK)
	$(Q)tar -C build -xJf $(GPU_CHECK)
	$(Q)build/gpu-check/check.py build/gpu-check.md || { [ $$? = 2 ] && \
	    echo "On a machine with a GPU: tar xJf gpu-check.tar.xz && gpu-check/check.py gpu-check.md"; }

# --- validation -----------------------------------------------------------
$(O)/bin/validate_water: $(OBJ)/tests/validate/water.o \
    $(OBJ)/tests/validate/watersampling.o $(OBJ)/tests/validate/waterslopes.o \
    $(OBJ)/tests/validate/waterchecks.o $(OBJ)/tests/validate/watercanonical.o \
    $(OBJ)/tests/validate/waterrays.o $(OBJ)/tests/validate/watercolumn.o \
    $(OBJ)/tests/validate/photons.o $(OBJ)/libserver.a
	$(LINK) -lm
# Shares no source with what it judges.
SEATRACE := $(addprefix tests/validate/seatrace/,seaspectrum.c seasurface.c \
    searay.c sealight.c)
$(O)/bin/seatrace: $(call obj,tests/validate/seatrace/seatrace.c $(SEATRACE))
	$(LINK) -lm
$(O)/bin/seatrace_test: $(call obj,$(SEATRACE))

SHIPTRACE := $(SEATRACE) $(addprefix tests/validate/shiptrace/,shipmesh.c \
    shiplight.c)
$(O)/bin/shiptrace: $(call obj,tests/validate/shiptrace/shiptrace.c $(SHIPTRACE))
	$(LINK) -lm
$(O)/bin/shiptrace_test: $(call obj,$(SHIPTRACE))

AIRTRACE := $(addprefix tests/validate/airtrace/,airmodel.c airsun.c \
    airground.c airglow.c airpath.c)
$(O)/bin/airtrace: $(call obj,tests/validate/airtrace/airtrace.c $(AIRTRACE))
	$(LINK) -lm
$(O)/bin/airtrace_test: $(call obj,$(AIRTRACE))
# The judged side.
$(O)/bin/airours: $(OBJ)/tests/validate/airtrace/airours.o $(OBJ)/libserver.a
	$(LINK) -lm

SPACETRACE := $(AIRTRACE) $(addprefix tests/validate/,spacetrace/spacesight.c \
    spacetrace/spacewaves.c seatrace/seaspectrum.c seatrace/seasurface.c \
    seatrace/searay.c)
$(O)/bin/spacetrace: $(call obj,tests/validate/spacetrace/spacetrace.c $(SPACETRACE))
	$(LINK) -lm
$(O)/bin/spacetrace_test: $(call obj,$(SPACETRACE))

UNDERTRACE := $(addprefix tests/validate/undertrace/,underphase.c \
    undersurface.c underpath.c)
$(O)/bin/undertrace: $(call obj,tests/validate/undertrace/undertrace.c $(UNDERTRACE))
	$(LINK) -lm
$(O)/bin/undertrace_test: $(call obj,$(UNDERTRACE))

$(O)/bin/cloudtrace: $(OBJ)/tests/validate/cloudtrace.o
	$(LINK) -lm

VALIDATE_PARTS := sea sky drawn numbers eye foam night ship space
VALIDATE_BIN := $(addprefix $(O)/bin/,seatrace shiptrace spacetrace airours validate_water brdf_test facets_test \
    directional_test ndbc_test welch_test cascade_test probe_test shimmer_test drawn_test space_rows_test \
    space_mixed_test)
.PHONY: validate $(addprefix validate-,$(VALIDATE_PARTS))
validate: deps-build ## light, waves, water, eye, ships against references: tables and plots in build/validate/ (ARGS=--quick: a minute)
	$(Q)$(MAKE) -s --no-print-directory all $(VALIDATE_BIN)
	$(Q)/usr/bin/python3 -B tests/validate/validate.py $(ARGS)
$(addprefix validate-,$(VALIDATE_PARTS)): validate-%: deps-build ## one part: sea sky drawn numbers eye foam night ship space, or water
	$(Q)$(MAKE) -s --no-print-directory all $(VALIDATE_BIN)
	$(Q)/usr/bin/python3 -B tests/validate/validate.py $(ARGS) $*

.PHONY: validate-water validate-seatrace airtable sheet beaufort-sheet day-sheet
validate-water: deps-build ## light in the water against Monte Carlo (ARGS=--quick, --sampling, --slopes)
	$(Q)$(MAKE) -s --no-print-directory $(O)/bin/validate_water
	$(O)/bin/validate_water $(ARGS)
	$(Q)cat build/validate$(if $(filter --quick,$(ARGS)),/quick)/water.md
validate-seatrace: deps-build ## its part sea with options of its own, as ARGS='--spectrum elfouhaily'
	$(Q)$(MAKE) -s --no-print-directory all $(O)/bin/seatrace
	$(Q)nice -n 10 /usr/bin/python3 -B tests/validate/seatrace/seatrace.py $(ARGS)
airtable: deps-build ## the sky's table anew by its Monte Carlo, about an hour of two cores
	$(Q)$(MAKE) -s --no-print-directory $(O)/bin/airtrace
	$(Q)/usr/bin/python3 -B tests/validate/airtrace/airtable.py $(ARGS)
.PHONY: validate-clouds
validate-clouds: deps-build ## light through a slab of cloud by Monte Carlo, its own checks first (ARGS='--photons N'): build/validate/clouds.txt
	$(Q)$(MAKE) -s --no-print-directory all $(O)/bin/cloudtrace
	$(Q)mkdir -p build/validate
	$(O)/bin/cloudtrace --check
	$(O)/bin/cloudtrace $(ARGS) > build/validate/clouds.txt
	$(Q)/usr/bin/python3 -B tests/validate/clouds.py | tee build/validate/clouds.md
.PHONY: validate-lamps
validate-lamps: deps-build ## a lamp's path on the sea against facets at random (ARGS='--quick --assert')
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/validate/lamps.py $(ARGS)
.PHONY: sensor-sheet
sensor-sheet: deps-build ## a scene as eye, low light, heat and radar see it: build/sensors.jpg
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/validate/sensor_sheet.py $(ARGS)
sheet: deps-build ## 24 scenes on one sheet, with figures: build/sheet.jpg
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/validate/sheet.py $(ARGS)

beaufort-sheet: deps-build ## the sea of Beaufort 0 to 11 on one sheet: build/beaufort.jpg
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/validate/beaufort.py $(ARGS)

day-sheet: deps-build ## 24 hours of a day with a full Moon on one sheet: build/day.jpg (ARGS=--dark: at new Moon)
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/validate/daysheet.py $(ARGS)
.PHONY: dusk-sheet
dusk-sheet: deps-build ## dusk, Sun +4 to -18 degrees, as eye and camera see it, on one sheet: build/dusk.jpg
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/validate/dusksheet.py $(ARGS)
.PHONY: visibility-sheet
visibility-sheet: deps-build ## visibility 200 m to 40 km, fog in layers and banks on one sheet: build/visibility.jpg
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/validate/visibility.py $(ARGS)
.PHONY: weather-sheet
weather-sheet: deps-build ## rain and snow by rate, by day, dusk and Moon on one sheet: build/weather.jpg
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/validate/weather.py $(ARGS)
.PHONY: lamps-sheet
lamps-sheet: deps-build ## a bridge's five windows by night, with traffic, on one sheet: build/lamps.jpg
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/validate/lampsheet.py $(ARGS)
.PHONY: octas-sheet
octas-sheet: deps-build ## clouds by cover, Sun and genus on one sheet: build/octas.jpg
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/validate/octas.py $(ARGS)

.PHONY: page-access
page-access: deps ## axe over every state of the page at three sizes, phones, keys: ten minutes
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)node tests/page/page_access_test.mjs
	$(Q)node tests/page/page_phone_test.mjs

.PHONY: attacks
attacks: deps ## attacks by a watch token while an instructor works, ATTACK_SECONDS (10) each: a table of waits and the bars missed (ARGS="hls_left …", "--parent DIR")
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/soak/attacks.py $(ARGS)

.PHONY: chaos
chaos: deps ## all faults at once for CHAOS_SECONDS (3600) by CHAOS_SEED (1), and what was promised meanwhile
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)/usr/bin/python3 -B tests/soak/chaos.py

.PHONY: dataset-check
dataset-check: deps ## 200 shards of 50 frames, undisturbed and with 30 kills: every frame once, equal digests
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)DATASET_SHARDS=200 DATASET_FRAMES=50 DATASET_KILLS=30 \
	    /usr/bin/python3 -B tests/dataset_test.py Sets

.PHONY: viewers-check
viewers-check: deps ## HLS to READERS (500) by two edges, one of which is killed; WebRTC by STUN and TURN
	$(Q)$(MAKE) -s --no-print-directory all
	$(Q)READERS=$(or $(READERS),500) PLAY_S=60 /usr/bin/python3 -B tests/viewers_test.py
	$(Q)/usr/bin/python3 -B tests/whep/ways.py

# Random walks (docs/machines.md).
WALKS := $(addprefix $(O)/bin/,machines_test session_walk_test credit_walk_test places_test)
.PHONY: soak
soak: deps ## a million steps of each walk; load every input, then a CIGI host, for SOAK_SECONDS (600) each; 64 viewers
	$(Q)$(MAKE) -s --no-print-directory all $(WALKS) $(O)/bin/pelagosd-starved
	$(Q)for w in $(WALKS); do PELAGOS_STEPS=1000000 $$w || exit 1; done
	$(Q)/usr/bin/python3 -B tests/soak/soak.py
	$(Q)/usr/bin/python3 -B tests/soak/cigi.py
	$(Q)SOAK=1 /usr/bin/python3 -B tests/stream_test.py \
	    Crowd.test_stalled_among_good Rtsp.test_stalled_client_delays_nobody
	$(Q)DURABLE_KILLS=1000 /usr/bin/python3 -B tests/durable_test.py \
	    Durable.test_kill_loses_no_answered_edit \
	    Durable.test_kill_while_edits_are_written
	$(Q)STARVE_ALL=1 /usr/bin/python3 -B tests/starve_test.py
	$(Q)DAY_FRAMES=$(or $(DAY_FRAMES),200000) /usr/bin/python3 -B tests/soak/day.py
	$(Q)LOSSES=1000 /usr/bin/python3 -B tests/loss_test.py \
	    Loss.test_pictures_are_the_same
	$(Q)SOAK=1 /usr/bin/python3 -B tests/bounds_test.py
	$(Q)SOAK=1 /usr/bin/python3 -B tests/sockets_test.py
	$(Q)SOAK=1 /usr/bin/python3 -B tests/security_test.py \
	    Limits.test_viewer_that_answers_no_ping
	$(Q)node tests/bench/latency.mjs --seconds 60

# --- style ---------------------------------------------------------------
C_FILES = $(shell find server proto clients tests -name '*.[ch]' 2>/dev/null | sort)

.PHONY: lint lint-layers lint-headers lint-format lint-tidy
LINT = $(shell find tests/lint -maxdepth 1 -type f -perm -u+x | sort)
lint: deps build/compile_commands.json ## walls, headers, format, clang-tidy, log ids, names of files: all of tests/lint/
	$(Q)tests/run $(LINT)
lint-layers lint-headers lint-format lint-tidy: lint-%: build/compile_commands.json
	$(Q)tests/lint/$*.py
.PHONY: lint-deep
lint-deep: deps build/compile_commands.json ## clang-tidy as far as its analyser goes by itself: twenty minutes of two cores
	$(Q)tests/lint/tidy.py --deep

# clangd finds it there; so does what lints.
.PHONY: compile_commands.json
compile_commands.json: build/compile_commands.json ## how each source is compiled, for clangd: build/compile_commands.json
define command
{ "directory": "$(CURDIR)", "file": "$(1)",
  "command": "$(subst ",\",$(subst \,\\,$(call compile,$(basename $(1))))) -c $(1)" },
endef
define newline


endef
build/compile_commands.json: FORCE | $(GEN_HEADERS)
	$(Q)$(file >$@.new,[$(foreach f,$(filter %.c,$(C_FILES)),$(newline)$(call command,$(f))))
	$(Q)sed -i '$$s/,$$/ ]/' $@.new; cmp -s $@.new $@ && rm $@.new || mv $@.new $@

.PHONY: format
format: ## rewrite the C sources as .clang-format says
	$(Q)clang-format -i $(C_FILES)
FUZZ_SECONDS ?= 60
# What a target needs beside the server: sources and libraries of readers.
FUZZ_WITH_fuzz_coast := server/continents/reader/coastlines.c
FUZZ_LIBS_fuzz_coast = $(SPECTRUM_LIBS)
FUZZ_WITH_fuzz_spectrum := $(addprefix server/ocean/reader/,netcdfform.c buoy.c datawell.c spotter.c)
FUZZ_LIBS_fuzz_spectrum = $(SPECTRUM_LIBS)
FUZZ_WITH_fuzz_forecast := $(addprefix server/weather/reader/,axis.c fills.c gribfile.c names.c netcdfaxes.c netcdffile.c netcdfholes.c netcdfproduct.c) server/seabed/reader/hdf5.c
FUZZ_LIBS_fuzz_forecast = $(WEATHER_LIBS)
FUZZ_WITH_fuzz_raster := $(addprefix server/seabed/reader/,gdal.c hdf5.c exr.c meaning.c netcdf.c undeclared.c)
FUZZ_LIBS_fuzz_raster = $(READER_LIBS) $(SPECTRUM_LIBS)
FUZZ_WITH_fuzz_picture := $(addprefix server/panorama/reader/,equirect.c equirectexr.c equirectrgbe.c) server/models/reader/gltfcheck.c
FUZZ_LIBS_fuzz_picture = $(READER_LIBS) $(SPECTRUM_LIBS) $(MODEL_LIBS)
FUZZ_LIBS_fuzz_roles = $(SPECTRUM_LIBS)
# GDAL and ecCodes keep what the end of their process frees.
FUZZ_LEAKY := fuzz_forecast fuzz_raster
define fuzz_rule
$(O)/bin/$(1): $(call obj,tests/fuzz/$(1).c tests/fuzz/unshaded.c $(FUZZ_WITH_$(1))) $(OBJ)/libserver.a
	$$(LINK) -fsanitize=fuzzer $$(PKG_LIBS) $$(FUZZ_LIBS_$(1))
endef
$(foreach t,$(basename $(notdir $(FUZZERS))),$(eval $(call fuzz_rule,$(t))))

.PHONY: fuzz
fuzz: deps ## fuzz every input for FUZZ_SECONDS (60) under ASan and UBSan
ifneq ($(FLAVOR),fuzz)
	$(Q)$(MAKE) FLAVOR=fuzz fuzz
else
fuzz: $(fuzz_bin)
	$(Q)/usr/bin/python3 -B tests/fuzz/seeds.py $(O)/seeds
	$(Q)for f in $(fuzz_bin); do \
	    name=$$(basename $$f); corpus=build/corpus/$$name; \
	    seeds=tests/fuzz/corpus/$$name; mkdir -p $$corpus; \
	    echo "== $$name, $(FUZZ_SECONDS) s"; \
	    case " $(FUZZ_LEAKY) " in *" $$name "*) leaks=0;; *) leaks=1;; esac; \
	    ASAN_OPTIONS=detect_leaks=$$leaks $$f -max_total_time=$(FUZZ_SECONDS) -timeout=60 -rss_limit_mb=2048 \
	        -print_final_stats=1 -artifact_prefix=$$corpus/ $$corpus \
	        $$(for s in $$seeds $(O)/seeds/$$name; do [ -d $$s ] && echo $$s; done) \
	        $$(d=tests/fuzz/$$name.dict; [ -f $$d ] && echo -dict=$$d) \
	        2>$$corpus.log \
	        || { tail -40 $$corpus.log; exit 1; }; \
	    grep -E 'stat::number_of_executed_units|stat::new_units' $$corpus.log; \
	done
endif

.PHONY: fuzz-coverage
fuzz-coverage: deps ## lines of each parser that the corpora of make fuzz reach, of 85 %: build/cover/report.txt
ifneq ($(FLAVOR),cover)
	$(Q)$(MAKE) FLAVOR=cover fuzz-coverage
else
fuzz-coverage: $(fuzz_bin)
	$(Q)tests/fuzz/coverage.sh $(O) $(fuzz_bin)
endif

# --- installation ---------------------------------------------------------
SYSCONFDIR ?= /etc
UNITDIR ?= $(PREFIX)/lib/systemd/system
SYSUSERSDIR ?= $(PREFIX)/lib/sysusers.d
TMPFILESDIR ?= $(PREFIX)/lib/tmpfiles.d
LIBDIR ?= $(PREFIX)/lib
D = $(DESTDIR)$(PREFIX)
L = $(DESTDIR)$(LIBDIR)

MANUALS := $(O)/man/pelagosd.8 $(O)/man/pelagosctl.1

$(O)/man/pelagosd.8: $(O)/bin/pelagosd
	$(Q)mkdir -p $(@D) && $< --print-man >$@
$(O)/man/pelagosctl.1: $(O)/bin/pelagosctl
	$(Q)mkdir -p $(@D) && $< manual >$@

.PHONY: man
man: $(MANUALS) ## make the manual pages, from the programs' own tables

# Of this PREFIX, whatever the last one was.
$(O)/pelagos.pc: FORCE
	$(Q)mkdir -p $(@D)
	$(Q)printf '%s\n' 'prefix=$(PREFIX)' \
	    'libdir=$(patsubst $(PREFIX)/%,$${prefix}/%,$(LIBDIR))' \
	    'Name: libpelagos' \
	    'Description: C client of pelagosd, the headless ocean renderer' \
	    'Version: $(VERSION)' 'Requires: libprotobuf-c' \
	    'Requires.private: openssl' 'Libs: -L$${libdir} -lpelagos' \
	    'Cflags: -I$${prefix}/include/pelagos' >$@

EXERCISES = $(wildcard clients/exercises/*.json)

# What brings pictures to many viewers (proto/live.md).
VIEWERS := packaging/nginx/edge.conf packaging/haproxy/haproxy.cfg \
    packaging/haproxy/placed.cfg     packaging/relay/pelagos-relay

# The files that `install` writes, for `uninstall`; then the folders.
INSTALLED = $(D)/bin/pelagosd $(D)/bin/pelagosctl \
    $(addprefix $(D)/libexec/pelagos/,pelagos-seabed pelagos-model pelagos-panorama pelagos-spectrum pelagos-continents pelagos-weather) \
    $(addprefix $(L)/,libpelagos.a $(SHARED) libpelagos.so.$(ABI) libpelagos.so \
        pkgconfig/pelagos.pc) \
    $(addprefix $(D)/include/pelagos/,$(notdir $(PUBLIC))) \
    $(addprefix $(D)/share/pelagos/,pelagos.proto openapi.json pelagos.conf) \
    $(addprefix $(D)/share/pelagos/exercises/,$(notdir $(EXERCISES))) \
    $(addprefix $(D)/share/pelagos/viewers/,$(notdir $(VIEWERS))) \
    $(D)/share/man/man1/pelagosctl.1 $(D)/share/man/man8/pelagosd.8 \
    $(addprefix $(D)/share/bash-completion/completions/,pelagosd pelagosctl) \
    $(D)/share/zsh/site-functions/_pelagosctl \
    $(D)/share/fish/vendor_completions.d/pelagosctl.fish \
    $(DESTDIR)$(UNITDIR)/pelagosd.service \
    $(DESTDIR)$(SYSUSERSDIR)/pelagos.conf $(DESTDIR)$(TMPFILESDIR)/pelagos.conf
# The deepest first. Those that `install` made it names in FOLDERS, so that
# `uninstall` takes no folder of others, empty or not.
above = $(if $(filter-out / . $(DESTDIR) $(DESTDIR)/,$(1)),$(1) $(call above,$(patsubst %/,%,$(dir $(1)))))
INSTALLED_FOLDERS = $(shell printf '%s\n' $(sort $(foreach f,$(patsubst %/,%,$(dir $(INSTALLED))) $(DESTDIR)$(SYSCONFDIR)/pelagos,$(call above,$(f)))) | sort -r)
FOLDERS = $(D)/share/pelagos/folders

# The loader finds a new library once it is told; a package's own scripts do it
# where DESTDIR is.
TELL_LOADER = $(Q)if [ -z '$(DESTDIR)' ] && [ "$$(id -u)" = 0 ]; then ldconfig; fi

.PHONY: install
install: all man $(O)/pelagos.pc $(O)/libpelagos.a $(O)/$(SHARED) ## install below PREFIX (/usr/local) and DESTDIR
	$(Q)made=$$(for folder in $(INSTALLED_FOLDERS); do \
	    [ -d $$folder ] || echo $${folder#$(DESTDIR)}; done) && \
	install -d $(sort $(dir $(INSTALLED))) $(DESTDIR)$(SYSCONFDIR)/pelagos && \
	if [ -n "$$made" ]; then printf '%s\n' $$made >>$(FOLDERS); fi
	install -m755 $(O)/bin/pelagosd $(O)/bin/pelagosctl $(D)/bin
	install -m755 $(O)/bin/pelagos-seabed $(O)/bin/pelagos-model \
	    $(O)/bin/pelagos-panorama $(O)/bin/pelagos-spectrum $(O)/bin/pelagos-continents $(O)/bin/pelagos-weather $(D)/libexec/pelagos
	install -m644 $(O)/libpelagos.a $(O)/$(SHARED) $(L)
	ln -sf $(SHARED) $(L)/libpelagos.so.$(ABI)
	ln -sf libpelagos.so.$(ABI) $(L)/libpelagos.so
	install -m644 $(O)/pelagos.pc $(L)/pkgconfig
	install -m644 $(PUBLIC) $(D)/include/pelagos
	install -m644 proto/pelagos.proto $(O)/gen/openapi.json \
	    packaging/nginx/pelagos.conf $(D)/share/pelagos
	install -m644 $(filter-out %-relay,$(VIEWERS)) $(D)/share/pelagos/viewers
	install -m755 $(filter %-relay,$(VIEWERS)) $(D)/share/pelagos/viewers
	install -m644 $(EXERCISES) $(D)/share/pelagos/exercises
	install -m644 $(O)/man/pelagosctl.1 $(D)/share/man/man1
	install -m644 $(O)/man/pelagosd.8 $(D)/share/man/man8
	$(O)/bin/pelagosd --print-completion \
	    >$(D)/share/bash-completion/completions/pelagosd
	$(O)/bin/pelagosctl completion bash \
	    >$(D)/share/bash-completion/completions/pelagosctl
	$(O)/bin/pelagosctl completion zsh >$(D)/share/zsh/site-functions/_pelagosctl
	$(O)/bin/pelagosctl completion fish \
	    >$(D)/share/fish/vendor_completions.d/pelagosctl.fish
	sed 's,/usr/local/bin,$(PREFIX)/bin,' packaging/pelagosd.service \
	    >$(DESTDIR)$(UNITDIR)/pelagosd.service
	install -m644 packaging/sysusers.conf $(DESTDIR)$(SYSUSERSDIR)/pelagos.conf
	install -m644 packaging/tmpfiles.conf $(DESTDIR)$(TMPFILESDIR)/pelagos.conf
	test -e $(DESTDIR)$(SYSCONFDIR)/pelagos/pelagosd.conf || \
	    install -m644 packaging/pelagosd.conf $(DESTDIR)$(SYSCONFDIR)/pelagos
	$(TELL_LOADER)

.PHONY: uninstall
uninstall: ## remove what `install` with the same PREFIX and DESTDIR put there
	$(Q)made=$$(sort -ru $(FOLDERS) 2>/dev/null); \
	rm -f $(INSTALLED) $(FOLDERS); \
	conf=$(DESTDIR)$(SYSCONFDIR)/pelagos/pelagosd.conf; \
	if cmp -s packaging/pelagosd.conf $$conf; then rm -f $$conf; \
	elif [ -e $$conf ]; then echo "kept, since it was changed: $$conf"; fi; \
	for folder in $$made; do folder=$(DESTDIR)$$folder; \
	    [ ! -d $$folder ] || [ -L $$folder ] || \
	        rmdir --ignore-fail-on-non-empty $$folder; done
	$(TELL_LOADER)

# --- packages to hand on ----------------------------------------------------
DIST := build/dist
TARBALL := $(DIST)/pelagos-$(VERSION).tar.xz

.PHONY: dist dist-check
dist: deps-page ## the committed sources, and what the page embeds, as a tarball: build/dist/
	$(Q)mkdir -p $(DIST)
	$(Q)git archive --format=tar \
	    $(foreach f,$(wildcard $(addprefix $(THIRD)/,$(foreach e,$(EMBEDDED),$(lastword $(subst =, ,$(e)))))),--prefix=pelagos-$(VERSION)/third-party$(patsubst $(THIRD)%,%,$(dir $(f))) --add-file=$(f)) \
	    --prefix=pelagos-$(VERSION)/ HEAD | xz -T0 >$(TARBALL)
	@ls -l $(TARBALL)
dist-check: dist deps-build ## unpack the tarball elsewhere, build and install it there
	$(Q)packaging/dist_check.sh $(TARBALL) $(VERSION)

.PHONY: wheel
wheel: ## the Python client as a wheel: build/dist/
	$(Q)mkdir -p $(DIST)
	$(Q)packaging/wheel.sh $(DIST)

DEB := build/deb
.PHONY: deb
deb: deps-build ## Debian packages of the committed sources: build/deb/
	$(Q)packaging/deps.sh $(DEB_PACKAGES) $(SITE_PACKAGES)
	$(Q)packaging/deb.sh $(DEB) '$(BUILD_PACKAGES)' '$(SITE_PACKAGES)' $(THIRD) $(EMBEDDED)

.PHONY: deb-check
deb-check: deps deb ## lintian, install, the unit under systemd, purge: of what `make deb` built
	$(Q)tests/packages/deb_test.sh $(DEB)

IMAGE := build/image/pelagos-$(VERSION).tar
.PHONY: image
image: deb ## an OCI image of the packages, without a registry, as root: build/image/
	$(Q)packaging/deps.sh mmdebstrap umoci
	$(Q)packaging/image.sh $(DEB) $(IMAGE) $(VERSION)

# --- documentation site -----------------------------------------------------
SITE ?= build/site
.PHONY: site
site: deps-build man $(O)/gen/openapi.json ## the documentation as HTML, with its search, for no network: build/site/
	$(Q)packaging/deps.sh $(SITE_PACKAGES)
	$(Q)packaging/site/build.sh $(O)/gen/openapi.json $(O)/man $(SITE)

PYTHON_DOCS ?= build/python-docs
.PHONY: python-docs
python-docs: ## the Python client's reference as HTML: build/python-docs/
	$(Q)/usr/bin/python3 -B -m sphinx -q -E -W --keep-going -b html \
	    -d $(PYTHON_DOCS)/.doctrees clients/python/docs $(PYTHON_DOCS)
	@echo $(PYTHON_DOCS)/index.html

.PHONY: clean
clean: ## remove build/
	rm -rf build

.PHONY: help
help: ## list the targets
	@grep -hE '^[a-z_.-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t16

-include $(shell find $(OBJ) -name '*.d' 2>/dev/null)
