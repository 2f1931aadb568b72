"""Seeds of the fuzzers of spectra, weather, roles, the store of sealed frames and
HLS. For seeds.py."""
import struct
from json import dumps


# --- wave spectra -------------------------------------------------------------

def swan(head="SWAN 1\n$ a test\n", time="TIME\n 1\n", places="LONLAT\n 2\n "
         "10.0 50.0\n 12.5 51.0\n", frequencies="AFREQ\n 3\n.05\n.1\n.2\n",
         directions="NDIR\n 4\n 0 90 180 270\n",
         quantity="QUANT\n 1\nVaDens x\nm2/Hz/degr unit\n -99 none\n",
         records=("20161011.120000\nNODATA\nZERO\n20161011.130000\nFACTOR\n"
                  "0.01\n1 2 3 4\n5 6 7 8\n-99 1 2 3\nZERO\n")):
    return head + time + places + frequencies + directions + quantity + records


def ww3(head="'WAVEWATCH III SPECTRA' 3 4 2 'a test'\n", axes="0.05 0.1 0.2\n"
        "0 1.57 3.14 4.71\n", time="20220912 060000\n", first="'one       '",
        values="1 2 3 4 5 6 7 8 9 10 11 12\n"):
    point = " 50.0 10.0 100.0 8.0 270.0 0.1 90.0\n"
    return head + axes + time + first + point + values + "'two'" + point + values


def historical(head="#YY  MM DD hh mm .0500 .1000 .2000", date="2020 06 08 03 00",
               values="1.0 2.0 MM"):
    return head + "\n" + date + " " + values + "\n"


def year(letters=5, **more):
    rows = ["1.0 2.0 MM", "240 999.0 90", "240 90 90", "0.8 0.5 0.5",
            "0.5 0.2 0.1"]
    return "\1".join(historical(values=r, **more) for r in rows[:letters])


NDBC = ("#YY  MM DD hh mm Sep_Freq  < spec_1 (freq_1) ... >\n"
        "2020 06 08 03 50 0.225 0.500 (0.100) 1.250 (0.200) 0.030 (0.300)\n"
        "2020 06 08 02 50 9.999 0.400 (0.100) 1.000 (0.200) 0.020 (0.300)\n")


def ndbc(alpha="90.0 (0.100) 180.0 (0.200) 999.0 (0.300)",
         r="0.50 (0.100) 0.60 (0.200) 999.00 (0.300)"):
    date = "2020 06 08 03 50 "
    return "\1".join([NDBC, *(date + v + "\n" for v in (alpha, alpha, r, r))])


def netcdf_spectrum(kind="efth", station="station 2", more="", units="a units "
                    "days since 1990-01-01T00:00:00Z", nd=4, nf=3, drop=""):
    name, size = station.split()
    lines = ["d time 1", f"d {name} {size}", f"d frequency {nf}",
             f"d direction {nd}", "d text 8", "v time d time", units,
             "v frequency f frequency", "v direction f direction",
             "a standard_name sea_surface_wave_from_direction", "a units degree",
             f"v latitude d {name}", f"v longitude d {name}",
             f"v station_name c {name} text",
             f"v {kind} f time {name} frequency direction", more,
             "= time 11000", "= frequency 0.05 0.1 0.2", "= direction 0 90 180 "
             "270", "= latitude 50", "= longitude 10", "= station_name one     ",
             f"= {kind} 1 2 3 4 5"]
    return "\n".join(x for x in lines if not (drop and drop in x))


def era5(more=""):
    return "\n".join([
        "d longitude 2", "d latitude 1", "d direction 24", "d frequency 30",
        "d time 1", "v longitude f longitude", "v latitude f latitude",
        "v time i time", "a units hours since 1900-01-01 00:00:00.0",
        "v d2fd s time frequency direction latitude longitude",
        "a scale_factor #0.0002", "a add_offset #-5", "a _FillValue #-32767",
        more, "= longitude 0 36", "= latitude 40", "= time 1055811",
        "= d2fd 1 200 -32767 3000"])


def buoy(drop="", station="station 1"):
    name, size = station.split()
    names = ("spectral_wave_density", "mean_wave_dir", "principal_wave_dir",
             "wave_spectrum_r1", "wave_spectrum_r2")
    lines = ["d time 2", f"d {name} {size}", "d frequency 3", "v time d time",
             "a units seconds since 1970-01-01", "v frequency f frequency",
             "v latitude d time " + name, "v longitude d time " + name,
             *(f"v {n} f time {name} frequency" for n in names),
             "= time 1500000000 1500003600", "= frequency 0.05 0.1 0.2",
             "= latitude 50", "= longitude 10",
             *(f"= {n} {v}" for n, v in zip(names, (1, 200, 210, .8, .5)))]
    return "\n".join(x for x in lines if not (drop and drop in x))


def datawell(head="5\n200\n8\n3.6\n18\n15\n7\n0\n0\n0\n90\n66\n",
             band="1.0,210.0,36.0,0.00,3.00"):
    return head + "".join(f"0.{k}5,{band}\n" for k in range(1, 5))


def spotter(more="", **change):
    rows = {"frequency": "[0.1,0.2,0.3]", "varianceDensity": "[1,2,\"1\"]",
            "a1": "[0.4,0.4,0.4]", "b1": "[0.7,0.7,0.7]",
            "a2": "[-0.2,null,0]", "b2": "[0.4,0.4,0.4]",
            "direction": "[210,210,210]", "directionalSpread": "[36,36,36]",
            "timestamp": '"2026-06-21T12:00:00.000Z"', "latitude": "52.5",
            "longitude": "5.1", **change}
    return ('{"data":{"waves":[],"frequencyData":[{' + ",".join(
        f'"{k}":{v}' for k, v in rows.items() if v) + "}" + more
        + '],"spotterId":"SPOT-1"}}')


def new_seeds():
    """Spectra in the buoys' own forms."""
    spts = [datawell(), datawell("PTR\n5\n200\n8\n3.6\n"), datawell("x\ny\n"),
            datawell("5\n0\n8\n3\n"), datawell("5\n"), datawell(band="1,210"),
            datawell(band="0,210,36"), datawell(band="-1,999,80,2,9"),
            datawell(band="1,210,36,x"), datawell(band="1e300,1,1,1e9,1e9"),
            datawell() * 50]
    for i, text in enumerate(spts):
        yield f"spt-{i}", f"D- nan\n{text}"
    jsons = [spotter(), spotter(a1="", b1=""), spotter(a2="", b2=""),
             spotter(direction="[30,30,30]"), spotter(frequency="[1]"),
             spotter(varianceDensity="[null,null,null]"), spotter(",{}"),
             spotter(timestamp='"2026-06-21T12:00+02:00"'), "[" * 40, "{",
             spotter(timestamp='"x"'), spotter(frequency='["x"]'),
             spotter("," + spotter()), spotter(frequency="[]"), '{"a":"\\"',
             '{"a":1,}', "[1,2", '{"spotterId":"a","x":[{}]}',
             spotter(frequency="[" + "1," * 200 + "1]")]
    for i, text in enumerate(jsons):
        for k, want in enumerate(("- nan", "SPOT-1 1782043200", "x 0")):
            yield f"spotter-{i}-{k}", f"J{want}\n{text}"


def spectrum_seeds():
    yield from new_seeds()
    swans = [swan(), swan(places="LOCATIONS\n 1\n 1 2\n",
                          records="20161011.120000\nZERO\n"),
             swan(time="", records="ZERO\nZERO\n"), swan(head="SWAM\n"),
             swan(time="", records=""), swan(directions="CDIR\n 3\n0 120 240\n"),
             swan(directions="DIR\n"), swan(directions="NDIR\n 2\n 0 180\n"),
             swan(frequencies="RFREQ\n 3\n.2 .1 .05\n"),
             swan(frequencies="AFREQ\n 9999\n"), swan(frequencies="AFREQ\n2.5\n"),
             swan(frequencies="AFREQ\n 3\n.1 x\n"), swan(places="LONLAT\n x\n"),
             swan(places="LONLAT\n 2\n 1\n"), swan(places=""),
             swan(quantity="QUANT\n 1\nEnDens\nJ\n-99 x\n"),
             swan(quantity="QUANT\n 1\nHs\n"), swan(quantity="QUANT\n 2\n"),
             swan(quantity="QUANT\n 1\nVaDens\nunit\nnone\n"),
             swan(records="yesterday\n"), swan(records="20161011.120000\nx\n"),
             swan(records="20169911.120000\nZERO\nZERO\n"),
             swan(records="20161011.120000\nFACTOR\n1 2\n"), "SWAN", ""]
    for i, text in enumerate(swans):
        for k, want in enumerate(("- nan", "2 nan", "50,10 1476190800", "x nan",
                                  "9 nan", "- 0")):
            yield f"swan-{i}-{k}", f"S{want}\n{text}"
    ww3s = [ww3(), ww3(head="'WAVEWATCH III' 3"), ww3(axes="x"),
            ww3(head="'WAVEWATCH III SPECTRA' 3 4 0 'x'\n"),
            ww3(head="'WAVEWATCH III SPECTRA' 3 9999 1 'x'\n"),
            ww3(head="'WAVEWATCH III SPECTRA' 1 4 1 'x'\n"), ww3(time="x\n"),
            ww3(first="one"), ww3(first="'" + "x" * 60 + "'"), ww3(values="x"),
            ww3(time=""), ww3(axes="0.2 0.1 0.05\n0 1.57 3.14 4.71\n")]
    ww3s.append(ww3().split("2022")[0])
    for i, text in enumerate(ww3s):
        for k, want in enumerate(("one nan", "two 1662962400", "- nan", "1 0",
                                  "50.1,10.1 nan", "-50,10 nan")):
            yield f"ww3-{i}-{k}", f"W{want}\n{text}"
    years = [year(), year(3), year(1), year(head="#YY MM DD hh .05 .1 .2",
                                            date="20 06 08 03"),
             year(head="YYYY MM DD hh mm .05 .1 .2"), year(head="#XX"),
             year(head="#YY MM DD .05 .1 .2"), year(head="#YY MM DD hh mm .1"),
             year(head="#YY MM DD hh mm " + " ".join(["1"] * 200)),
             year(head="#YY MM DD hh mm .2 .1 .05"), year(date="2020 06 08 x"),
             year(date="2020 99 08 03 00"), year(date="1e300 06 08 03 00"),
             historical(values="1.0"), historical(values="1.0 2.0 x"),
             historical() + "\1" + historical(date="2020 06 08 04 00"),
             historical() + "\1" + historical(date="2020 06 08 09 00"), "#YY\0"]
    years.append(historical().split("\n")[0] + "\n")
    for i, text in enumerate(years):
        yield f"year-{i}", "H- nan\n" + text
    yield "year-then", "H- 1591585200\n" + year()
    buoys = [ndbc(), NDBC, ndbc(r="1.50 (0.100) 0.60 (0.200) 0.10 (0.300)"),
             ndbc(alpha="90.0 (0.100)"), ndbc(alpha="90 (0.1) 80 (0.2) 70 (0.4)"),
             ndbc(r="x"), ndbc(alpha="MM (0.1) MM (0.2) MM (0.3)"), "", "# only",
             "2020 06 08 03 50 0.2 0.5 (0.1) 1.2 0.2)", "<html>", "2020 06",
             "2020 13 08 03 50 0.2 0.5 (0.1)", "2020 06 08 24 50 0.2 0.5 (0.1)",
             "2020 06 08 03 50 0.2 nan (0.1)", NDBC + "\1" + "x", "a\0b",
             "2020 06 08 03 50 0.2 -0.5 (0.1)", "2020 06 08 03 50 0.2 0.5 (0.1",
             "2020 06 08 03 50 0.2" + " 1.0 (0.1)" * 300,
             "2020 06 08 03 50 0.2 1 (0.3) 1 (0.2) 1 (0.1)"]
    for i, text in enumerate(buoys):
        yield f"ndbc-{i}", "B- nan\n" + text
        yield f"ndbc-{i}-then", "B- 1591585000\n" + text
    files = [netcdf_spectrum(), netcdf_spectrum("density"), era5(), buoy(),
             netcdf_spectrum(station="station 1"), buoy("r2"), era5("v x d"),
             netcdf_spectrum(station="points 9"), netcdf_spectrum("energy"),
             netcdf_spectrum(units=""), netcdf_spectrum(units="a units x"),
             netcdf_spectrum(units="a units hours since x"),
             netcdf_spectrum(units="a units " + "x" * 600),
             netcdf_spectrum(units="a units minutes since 1990-1-1"),
             netcdf_spectrum(units="a units hours since 1600-1-1"),
             netcdf_spectrum(station="place 2"), netcdf_spectrum(nd=2),
             netcdf_spectrum(nf=2), netcdf_spectrum(nf=200),
             netcdf_spectrum(nd=1000), netcdf_spectrum(drop="time d"),
             netcdf_spectrum(drop="frequency f"), buoy("v latitude"),
             netcdf_spectrum(drop="direction f"), buoy("= time"),
             netcdf_spectrum(drop="v latitude"), netcdf_spectrum(drop="= efth"),
             netcdf_spectrum(more="a _FillValue #1"), buoy(station="site 3"),
             netcdf_spectrum().replace("= frequency 0", "= frequency 9"),
             netcdf_spectrum().replace("days", "1e300 days"),
             netcdf_spectrum().replace("= time 11000", "= time 1e300"),
             netcdf_spectrum().replace("direction f direction",
                                       "dir f direction"),
             netcdf_spectrum().replace("frequency f", "freq f"),
             netcdf_spectrum().replace("a units degree", "a units radians"),
             netcdf_spectrum().replace("frequency direction\n",
                                       "direction frequency\n"),
             netcdf_spectrum().replace("efth f", "efth c"),
             era5().replace("frequency 30", "frequency 9"),
             era5().replace("v latitude", "v altitude"),
             era5().replace("1 200 -32767", "-32767"), "d time 0", ""]
    for i, text in enumerate(files):
        for k, want in enumerate(("- nan", "2 nan", "one nan", "40,0.1 nan",
                                  "1 1581552000")):
            yield f"netcdf-{i}-{k}", f"N{want}\n{text}"


# --- weather ------------------------------------------------------------------

WEATHER = {"u10": 3, "v10": 4, "swh": 1.5, "pp1d": 8, "mwd": 240, "shww": 1,
           "mpts": 9, "mdts": 300}


def weather(names=WEATHER, units="hours since 2026-06-21 12:00:00",
            lat="54 53 52 51", lon="3 4 5", types="f", more=(), attributes=()):
    lines = ["d time 2", f"d latitude {len(lat.split())}",
             f"d longitude {len(lon.split())}", "v time d time",
             f"a units {units}", "a standard_name time", "v latitude d latitude",
             "a units degrees_north", "v longitude d longitude",
             "a units degrees_east"]
    for name in names:
        lines += [f"v {name} {types} time latitude longitude", *attributes]
    lines += [*more, "= time 0 1", f"= latitude {lat}", f"= longitude {lon}"]
    lines += [f"= {name} {value}" for name, value in names.items()]
    return "N" + "\n".join(lines)


def forecast_seeds():
    wind = {"u10": 3, "v10": 4}
    yield from {
        "whole": weather(), "wind": weather(wind), "none": weather({"x": 1}),
        "half": weather({"u10": 3}), "waves": weather(
            {k: v for k, v in WEATHER.items() if k not in ("mpts", "mdts")}),
        "few": weather(dict(wind, swh=1)), "units": weather(units="days"),
        "wind-only-waves": weather({"swh": 1, "pp1d": 8, "mwd": 1}),
        "south": weather(lat="51 52 53 54"), "polar": weather(
            lat=" ".join(str(90 - 10 * i) for i in range(19)),
            lon=" ".join(str(10 * i) for i in range(36))),
        "packed": weather(types="s", attributes=(
            "a scale_factor #0.01", "a add_offset #1", "a _FillValue #3")),
        "impossible": weather(dict(WEATHER, swh=900)),
        "impossible-wind": weather(dict(wind, u10=900)),
        "impossible-way": weather(dict(WEATHER, mwd=9000)),
        "nan": weather(dict(WEATHER, swh="nan 1 2")),
        "standard": weather({"a": 3, "b": 4}, attributes=(
            "a standard_name eastward_wind",)),
        "to": weather(dict(wind, swh=1, pp1d=8, way=30), more=(
            "a standard_name sea_surface_wave_to_direction",)),
        "uneven": weather(lat="54 53 51 40"), "large": weather(
            lat=" ".join(str(k / 50) for k in range(1500)), names=wind),
        "wide": weather(lon=" ".join(str(k / 20) for k in range(2500)),
                        names=wind),
        "other-grid": weather(wind, more=(
            "d lat 3", "d lon 3", "v lat d lat", "a units degrees_north",
            "v lon d lon", "a units degrees_east", "v swh f time lat lon",
            "= swh 1", "= lat 1 2 3", "= lon 1 2 3")),
        "late": weather(dict(wind), more=(
            "d hour 1", "v hour d hour", "a units hours since 2026-06-21",
            "v swh f hour latitude longitude", "= hour 5", "= swh 1")),
        "untimed": weather({}, more=(
            "v u10 f latitude longitude", "v v10 f latitude longitude",
            "= u10 1", "= v10 1")),
        "times": weather(wind).replace("d time 2", "d time 900").replace(
            "= time 0 1", "= time " + " ".join(map(str, range(900)))),
        "times-alike": weather(wind).replace("= time 0 1", "= time 1 1"),
        "times-vast": weather(wind).replace("= time 0 1", "= time 1e300 1"),
        "no-netcdf": "Fother bytes", "empty": "F", "cdf": "FCDF\1"}.items()
    for i, text in enumerate((
            "u10", "|eastward_wind", "||0|2|2", "||0|2|2|131", "|||||140239",
            "||10|0|3", "||10|0|10", "||10|0|14", "||192|140|239", "MWD", "",
            "||", "|||0", "|sea_surface_wave_to_direction", "m s**-1", "knots",
            "km/h", "0.01 m.s^-1", "metres per second", "degrees_true",
            "Degree (clockwise from north)", "radians", "fathom", "hours",
            "Hz", "m s-99999999999", "1e999 m", "/", "s2 m2")):
        yield f"kind-{i}", "K" + text
    for i, text in enumerate((
            "3 hours since 2026-06-21 12:00:00", "3 h since 2026-06-21T12:00:00",
            "3 days since 1900-1-1", "3 seconds since 1970-01-01 00:00:00 UTC",
            "3 min since 1970-01-01 00:00:00 Z", "3 s since 1970-01-01",
            "3 hours since 1970-01-01 00:00:00 +02:00", "3 months since 1-1-1",
            "1e300 days since 1900-1-1", "nan days since 1900-1-1", "x", "3",
            "3 days since -2147483648-1-1", "3 days since 1-99999-99999",
            "3 days since 1900-1-1 99:99:1e300",
            "739788 days since 0001-01-01|standard",
            "3 days since 1900-2-29|360_day", "59 days since 1901-1-1|360_day",
            "59 days since 1901-1-1|all_leap", "3 s since 1901-1-1|noleap",
            "-9e9 weeks since 9999-12-31|julian", "3 s since 1970-1-1|moon",
            "3 s since 1582-10-15|proleptic_gregorian")):
        yield f"time-{i}", "T" + text


# --- roles --------------------------------------------------------------------

def roles_seeds():
    token, other = "0123456789abcdef", "A" * 20 + "-._~+"
    for i, text in enumerate((
            token, token + "\n", f"{token} watch\n{other} steer bridge\r\n# x\n",
            f"{token} instruct\n\n  # y", f"{token}\n{other}", "", "# x",
            "short", "x" * 129, "0123456789abcde!", f"{token} king", f" {token}",
            f"{token} ", f"{token} watch a b", f"{token} watch " + "n" * 33,
            f"{token} watch\n{token} steer", "\n".join(
                f"{token}{k:02d} watch" for k in range(70)), token + "\0",
            "# " + "x" * 17000, "none 0123456789abcdef")):
        yield f"tokens-{i}", "T" + text
    for i, text in enumerate((
            "Bearer " + token, "bearer  " + token, "Bearer " + other, "Bearer ",
            "Basic eDowMTIzNDU2Nzg5YWJjZGVm", "Basic eDp5", "Basic x", "Basic ",
            "basic " + "eDp5" * 300, "Digest x", "", "Bearer " + token + " ")):
        yield f"header-{i}", "A" + text
    patches = [
        {"views": {"bridge": {"yaw": 3}}}, {"views": {"other": {"yaw": 3}}},
        {"entities": {"1": {"speed": 3}}}, {"entities": {"9": {"speed": 3}}},
        {"entities": [{"name": "ownship", "speed": 3}]}, {"sky": {"rain": 1}},
        {"entities": [{"name": "x", "speed": 3}]}, {"entities": {"1": None}},
        {"entities": {"1": {"helm": {"throttle": 1}}}}, {"ownShip": {"rudder": 9}},
        {"ownShip": {"throttle": 1}}, {"clock": {"mode": "STEPPED"}}, {},
        {"views": [{"name": "bridge", "pitch": 1}, {"name": "new"}]},
        {"sky": None}, {"presets": {"a": {}}}, {"revision": 3}]
    for i, patch in enumerate(patches):
        yield f"patch-{i}", dumps(patch)


# --- the store of sealed frames -----------------------------------------------

def varint(value):
    out = b""
    while value > 127:
        out += bytes([value & 127 | 128])
        value >>= 7
    return out + bytes([value])


def field(number, data):
    return varint(number << 3 | 2) + varint(len(data)) + data


def etcd_seeds():
    master = field(1, b"one") + b"\x10\1" + field(3, b"10.0.0.1:1")
    patch = field(4, field(1, field(6, field(1, b"x"))))
    frame = field(1, b"\x09" + struct.pack("<d", 1) + patch) + field(
        2, b"\x08\1" + field(5, bytes(32)) + field(6, b"one"))
    head = b"\x08\1\x10\7" + field(4, b"0.1") + field(6, b"llvmpipe")
    values = [("K", frame), ("M", master), ("N", field(1, b"two")), ("H", head),
              ("M", b""), ("M", field(1, b"one")), ("K", b"\xff" * 9), ("N", b"")]
    pairs = [letter + value.hex() for letter, value in values]
    pairs += [p + "0" for p in pairs]
    asks = [chr(98 + k) for k in range(7)]  # each of what % 7
    for ask in asks:
        for i, pair in enumerate(pairs):
            yield f"asked-{ord(ask)}-{i}", f"{ask}\n{pair}\n{ask}\ng\n{pair}"
    yield "all", "\n".join(a + "\n" + p for a, p in zip(asks * 3, pairs))
    yield "lost", "b\nL\nL"
    texts = ['{"header":{"revision":"9"},"succeeded":true}', "{}", "[", "x",
             '{"error":"no leader","code":14}', '{"error":{"message":"%s"}}'
             % ("x" * 300), '{"result":{"created":true,"header":{"revision":'
             '"7"}}}', '{"result":{"canceled":true,"compact_revision":"12"}}',
             '{"kvs":[{"key":"YnJpZGdlL2xvZw==","key":"YQ==","value":"eA==",'
             '"value":"eQ=="},{"value":"*"},{"key":3}]}',
             '{"kvs":[{"lease":"1"}]}', '{"a":{"kv":{"key":"YnJpZGdlL2xvZw=="}}}',
             '{"result":{"events":[{"type":"DELETE","kv":{"key":'
             '"YnJpZGdlL21hc3Rlcg==","mod_revision":"9"}},{"kv":{"key":'
             '"YnJpZGdlL2xvZw==","version":"2","value":""}}]}}',
             '{"%s":{"kvs":[{"key":"YQ=="}]}}' % ("x" * 300),
             '{"responses":[{"response_range":{"kvs":[{"key":'
             '"YnJpZGdlL2xvZw==","version":"1","value":"%s"}]}}]}' % "CgA="]
    for i, text in enumerate(texts):
        for letter in "AW":
            yield f"text-{letter}-{i}", "b\n" + letter + text
            yield f"put-{letter}-{i}", "d\n" + letter + text


# --- HLS ----------------------------------------------------------------------

def hls_seeds():
    # LIST, FILE_OF, FILE_NAMED, PICTURE, WAIT, FORGET, GONE
    def step(what, *data):
        return bytes([what, len(data), *data])

    def picture(later=9, key=0, size=7):
        return step(3, key, size, later)

    ask, key = step(0, 0), picture(key=6)
    film = (key + picture() * 6) * 9
    yield "film", ask + film + ask + b"".join(step(1, k) for k in range(40))
    yield "parts", ask + film + step(0, 0, 3) + step(0, 0, 7, 1) + picture(
    ) * 9 + step(0, 0, 9, 9) + step(0, 0, 200) + film
    yield "hint", ask + film + b"".join(
        step(1, k) + picture() for k in range(20, 60))
    yield "gap", ask + film + picture(200) + picture(200) + film + ask
    yield "idle", ask + film + step(4, 6) + step(4, 6) + ask + key
    yield "waits", ask + step(0, 2) + step(5, 0) + step(5, 3) + step(4, 6)
    yield "gone", ask + key + step(0, 0, 5) + step(6, 1) + ask + key
    yield "none", step(0, 1) + step(0, 3, 1, 1)
    yield "fails", ask + step(3, 7, 9, 1) * 5 + picture() * 5 + film
    yield "large", ask + (picture(9, 6, 255) + picture(9, 0, 255) * 6) * 12 + ask
    for i, name in enumerate((b"", b"x", b"00000000-1.ts", b"00000000-1-2.ts",
                              b"0123abcd-99999999999999999999999.ts",
                              b"0123abcd-1-99999999999999.ts", b"0123abcd-x.ts",
                              b"0123abcd-1.mp4", b"0123abcd-1-.ts")):
        yield f"name-{i}", ask + film[:99] + bytes([2, len(name)]) + name


SEEDS = [("spectrum", spectrum_seeds), ("forecast", forecast_seeds),
         ("roles", roles_seeds), ("etcd", etcd_seeds), ("hls", hls_seeds)]
