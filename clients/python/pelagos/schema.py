"""The state and answers as dataclasses: made by `make manual` from
proto/pelagos.proto; edit that.

Names are those of the wire, with `_` behind those that Python keeps for
itself (`class_`). Angles are degrees. None: absent."""
from __future__ import annotations

from dataclasses import dataclass

from .record import Record, _field

#: Of the client, and of the daemon that it was made with.
VERSION = "0.2.0"

#: The layers of an EXR picture.
LAYERS = (
    "radiance",
    "sun",
    "sky",
    "water",
    "air",
    "depth",
    "normal",
    "fresnel",
    "slopeVariance",
    "id",
    "class",
    "foam",
    "albedo",
    "waterSingle",
    "waterSecond",
    "waterHigher",
    "bottom",
    "position",
)

#: The formats of pictures, by their endings.
FORMATS = ("jpg", "png", "exr", "json")
#: Those of them with layers of floats.
LINEAR_FORMATS = ("exr",)
#: What entities are, in the order of the layer `class`.
MODEL_CLASSES = (
    "OTHER",
    "CONTAINER_SHIP",
    "TANKER",
    "BULK_CARRIER",
    "CARGO_SHIP",
    "FERRY",
    "CRUISE_SHIP",
    "TUG",
    "FISHING_BOAT",
    "SAILING_YACHT",
    "MOTOR_YACHT",
    "PILOT_LAUNCH",
    "PATROL_BOAT",
    "WARSHIP",
    "WORK_SHIP",
    "RIB",
    "USV",
    "ROWING_BOAT",
    "LATERAL_PORT",
    "LATERAL_STARBOARD",
    "CARDINAL_NORTH",
    "CARDINAL_EAST",
    "CARDINAL_SOUTH",
    "CARDINAL_WEST",
    "SAFE_WATER",
    "SPECIAL_MARK",
    "ISOLATED_DANGER",
    "BEACON",
    "LIGHT_FLOAT",
    "LIFE_RAFT",
    "LIFEBOAT",
    "PERSON",
)

#: Length and beam of the built-in models [m].
MODEL_SIZES = {
    "container-ship": (294, 32.2),
    "tanker": (244, 42),
    "bulk-carrier": (190, 32.2),
    "ferry": (186, 26),
    "cruise-ship": (294, 32.2),
    "tug": (32, 11.6),
    "fishing-boat": (24, 7.2),
    "sailing-yacht": (12, 3.9),
    "pilot-launch": (17, 5.2),
    "patrol-boat": (45, 7.6),
    "rib": (7.6, 2.7),
    "usv": (5.4, 2.6),
    "lateral-port-a": (3, 3),
    "lateral-starboard-a": (3, 3),
    "lateral-port-b": (3, 3),
    "lateral-starboard-b": (3, 3),
    "cardinal-north": (3, 3),
    "cardinal-east": (3, 3),
    "cardinal-south": (3, 3),
    "cardinal-west": (3, 3),
    "safe-water": (3, 3),
    "special-mark": (2.4, 2.4),
    "isolated-danger": (3, 3),
    "beacon": (3.2, 3.2),
    "light-float": (14, 5),
    "life-raft": (3.4, 3.4),
    "person": (0.45, 0.66),
}


@dataclass(frozen=True)
class Clock(Record):
    """Clock."""
    #: What makes simulated time advance.
    #: One of FREE, PACED, STEPPED, HOST.
    mode: str = _field('FREE',
        words="FREE PACED STEPPED HOST")
    #: Simulated seconds for each second of wall time. [1; 0 to 100]
    rate: float = _field(1.0, '1', 0, 100)
    #: Simulated time since the scene's epoch. [s; 0 to 1000000000]
    time: float = _field(0.0, 's', 0, 1000000000)
    #: UTC at simulated time 0, ISO 8601 (`2026-06-21T12:00:00Z`): with the
    #: origin it places the Sun when sky.sunElevation is not set.
    utc: str = _field('2026-06-21T12:00:00Z')
    #: How long an entity goes on from its last pose by its rates; then it
    #: stands, and pictures of such a moment are stale (`poses`). [s; 0 to
    #: 1000000000]
    reckoning: float = _field(60.0, 's', 0, 1000000000)


@dataclass(frozen=True)
class Origin(Record):
    """Where the local east-north-up frame touches the WGS 84 ellipsoid."""
    #: Geodetic latitude. [deg; -90 to 90]
    latitude: float = _field(52.6, 'deg', -90, 90)
    #: Longitude. [deg; -180 to 180]
    longitude: float = _field(5.2, 'deg', -180, 180)


@dataclass(frozen=True)
class Swell(Record):
    """One train of swell."""
    #: Significant wave height. [m; 0 to 15]
    height: float = _field(1.0, 'm', 0, 15)
    #: Peak period. [s; 3 to 30]
    period: float = _field(10.0, 's', 3, 30)
    #: Direction it comes from. [deg; 0 to 360]
    direction: float = _field(270.0, 'deg', 0, 360)
    #: Standard deviation of direction. [deg; 1 to 60]
    spread: float = _field(10.0, 'deg', 1, 60)


@dataclass(frozen=True)
class Wave(Record):
    """One wave of its own, for tests and tanks: exact as a trochoid; with
    synthesiser FFT of the nearest wavelength of its grids."""
    #: From crest to trough. [m; 0 to 15]
    height: float = _field(1.0, 'm', 0, 15)
    #: Period. [s; 1 to 30]
    period: float = _field(8.0, 's', 1, 30)
    #: Direction it comes from. [deg; 0 to 360]
    direction: float = _field(270.0, 'deg', 0, 360)
    #: Phase at the origin at simulated time 0; 0 is a crest. [deg; 0 to 360]
    phase: float = _field(0.0, 'deg', 0, 360)


@dataclass(frozen=True)
class Area(Record):
    """An area of the sea in which waves shorter than 3.7 m are higher or
    lower: a slick, a gust's cat's paw, water that rain calms. What is drawn,
    its glitter, its foam and what is queried change together."""
    #: Place of its centre, or of a polygon's corners' origin, east of the
    #: scene's origin. [m; -1000000 to 1000000]
    east: float = _field(0.0, 'm', -1000000, 1000000)
    #: The same, north. [m; -1000000 to 1000000]
    north: float = _field(0.0, 'm', -1000000, 1000000)
    #: Radius of a circle. [m; 1 to 100000]
    radius: float = _field(100.0, 'm', 1, 100000)
    #: Corners of a polygon instead, 3 to 16, east and north of the place, as
    #: "0 0, 400 0, 300 150", or 0:0,400:0,300:150; absent: a circle. [m; at
    #: most 512 bytes]
    corners: str | None = _field(None, 'm')
    #: What the short waves' heights are times. [1; 0 to 2]
    factor: float = _field(0.3, '1', 0, 2)
    #: Width in which it goes over into the sea around. [m; 1 to 10000]
    edge: float = _field(20.0, 'm', 1, 10000)
    #: Direction it moves to. [deg; 0 to 360]
    course: float = _field(0.0, 'deg', 0, 360)
    #: Speed it moves at. [m/s; 0 to 50]
    speed: float = _field(0.0, 'm/s', 0, 50)
    #: Simulated time at which it is at its place. [s; -1000000000 to
    #: 1000000000]
    time: float = _field(0.0, 's', -1000000000, 1000000000)


@dataclass(frozen=True)
class WeatherField(Record):
    """Weather by place and time, of a file of a weather service. While there
    is one it leads windSpeed, windDirection and, where it has waves, fetch and
    swell: they are the file's at own ship (without own ship at the origin), at
    the simulated UTC, and edits of them are refused. Wave heights need the
    spectrum JONSWAP or ELFOUHAILY; docs/numbers.md has the names that are
    read."""
    #: File in the directory of pelagosd --weather: GRIB or NetCDF with wind at
    #: 10 m and, if it has them, height, period and direction of waves, by
    #: time. [at most 512 bytes]
    file: str | None = _field(None)
    #: Added to the simulated UTC before the file is asked. [s; -10000000000 to
    #: 10000000000]
    shift: float = _field(0.0, 's', -10000000000, 10000000000)
    #: Written by the server, as all below, when the sea is brought to it:
    #: simulated time of that. [s; 0 to 1000000000]
    time: float | None = _field(None, 's', 0, 1000000000)
    #: Where. [deg; -90 to 90]
    latitude: float | None = _field(None, 'deg', -90, 90)
    #: Where. [deg; -180 to 180]
    longitude: float | None = _field(None, 'deg', -180, 180)
    #: Whether the file has that place and time.
    #: One of INSIDE, BEFORE, AFTER, OUTSIDE.
    place: str | None = _field(None,
        words="INSIDE BEFORE AFTER OUTSIDE")
    #: Whether it has numbers there, not land or ice, whose are the nearest
    #: coast's.
    known: bool | None = _field(None)
    #: Significant height that it has; absent: it has no waves. [m; 0 to 32]
    height: float | None = _field(None, 'm', 0, 32)
    #: Peak period. [s; 0 to 40]
    period: float | None = _field(None, 's', 0, 40)
    #: Direction that the waves come from. [deg; 0 to 360]
    direction: float | None = _field(None, 'deg', 0, 360)
    #: UTC of the file's first time.
    first: str | None = _field(None)
    #: UTC of its last.
    last: str | None = _field(None)
    #: Whether it leads wind and waves at own ship. Without, the sea stays as
    #: it is and can be edited, as in a replay, whose log has what the field
    #: did; seen from high up the weather is the field's all the same.
    leads: bool = _field(True)


@dataclass(frozen=True)
class Sea(Record):
    """Sea."""
    #: Mean wind speed 10 m above the sea. [m/s; 0 to 30]
    windSpeed: float = _field(8.0, 'm/s', 0, 30)
    #: Direction the wind blows from. [deg; 0 to 360]
    windDirection: float = _field(270.0, 'deg', 0, 360)
    #: Shape of the wind sea's spectrum.
    #: One of PIERSON_MOSKOWITZ, JONSWAP, TMA, ELFOUHAILY, OMEGA2, MEASURED,
    #: BRETSCHNEIDER.
    spectrum: str = _field('PIERSON_MOSKOWITZ',
        words="PIERSON_MOSKOWITZ JONSWAP TMA ELFOUHAILY OMEGA2 MEASURED "
        "BRETSCHNEIDER")
    #: Distance over which the wind has blown, for JONSWAP. [m; 1000 to
    #: 2000000]
    fetch: float = _field(200000.0, 'm', 1000, 2000000)
    #: Peak enhancement factor, for JONSWAP. [1; 1 to 7]
    gamma: float = _field(3.3, '1', 1, 7)
    #: Seed of the waves' phases and directions. [1; 0 to 4294967295]
    seed: int = _field(1, '1', 0, 4294967295)
    #: Swell trains, at most 8.
    swell: tuple[Swell, ...] = ()
    #: How the waves are made.
    #: One of TROCHOIDS, FFT.
    synthesiser: str = _field('FFT',
        words="TROCHOIDS FFT")
    #: Depth of the water, for the speed of the waves and TMA; absent: deep.
    #: [m; 1 to 11000]
    depth: float | None = _field(None, 'm', 1, 11000)
    #: Beaufort number: another way to write windSpeed, which it sets; not
    #: kept. [1; 0 to 10]
    beaufort: float | None = _field(None, '1', 0, 10)
    #: Degree of Douglas's sea scale: sets windSpeed so that the wind sea has
    #: its significant height; not kept. [1; 0 to 9]
    douglas: float | None = _field(None, '1', 0, 9)
    #: Of the spectrum MEASURED, in the directory of pelagosd --spectra: an
    #: NDBC STATION, or FILE.nc#STATION of other forms (docs/numbers.md). [at
    #: most 512 bytes]
    measured: str | None = _field(None)
    #: UTC of the record, ISO 8601, the nearest within 90 minutes; absent:
    #: newest.
    measuredTime: str | None = _field(None)
    #: Single waves, at most 8.
    wave: tuple[Wave, ...] = ()
    #: Height of the calm sea above altitude 0: tide and surge. [m; -20 to 20]
    level: float = _field(0.0, 'm', -20, 20)
    #: Significant wave height, for BRETSCHNEIDER. [m; 0 to 15]
    height: float = _field(2.0, 'm', 0, 15)
    #: Peak period, for BRETSCHNEIDER. [s; 3 to 30]
    period: float = _field(8.0, 's', 3, 30)
    #: Whether the glitter sparkles: each pixel mirrors the Sun by slopes of
    #: its own; the mean over pixels is the same without.
    sparkle: bool = _field(True)
    #: Whitecaps: the share of the sea that is foam, times what observations
    #: have at this wind (0.3 % at 8 m/s, 5 % at 18, 14 % at 25), with streaks
    #: and spray; 0: none are drawn. [1; 0 to 4]
    whitecaps: float = _field(1.0, '1', 0, 4)
    #: Areas of higher or lower short waves, at most 16.
    areas: tuple[Area, ...] = ()
    #: Weather by place and time, which leads wind and waves.
    field: WeatherField | None = _field(None)


@dataclass(frozen=True)
class Water(Record):
    """What the water is made of, for light: by chlorophyll, unless one of
    jerlov, named, or the six coefficients of absorption and scattering says
    otherwise. docs/physics/water.md has the sources of all numbers."""
    #: Chlorophyll-a concentration; the other constituents follow it as in Case
    #: 1 waters, where they are not given. [mg/m3; 0.01 to 30]
    chlorophyll: float = _field(0.2, 'mg/m3', 0.01, 30)
    #: Jerlov's type, instead of chlorophyll.
    #: One of I, IA, IB, II, III, C1, C3, C5, C7, C9.
    jerlov: str | None = _field(None,
        words="I IA IB II III C1 C3 C5 C7 C9")
    #: A known water, instead of chlorophyll.
    #: One of TROPICAL, NORTH_ATLANTIC, BALTIC, HARBOUR.
    named: str | None = _field(None,
        words="TROPICAL NORTH_ATLANTIC BALTIC HARBOUR")
    #: Absorption at 680 nm; with the other two and scattering, instead of
    #: chlorophyll. [1/m; 0.001 to 100]
    absorption680: float | None = _field(None, '1/m', 0.001, 100)
    #: Absorption at 550 nm. [1/m; 0.001 to 100]
    absorption550: float | None = _field(None, '1/m', 0.001, 100)
    #: Absorption at 440 nm. [1/m; 0.001 to 100]
    absorption440: float | None = _field(None, '1/m', 0.001, 100)
    #: Scattering at 680 nm. [1/m; 0 to 100]
    scattering680: float | None = _field(None, '1/m', 0, 100)
    #: Scattering at 550 nm. [1/m; 0 to 100]
    scattering550: float | None = _field(None, '1/m', 0, 100)
    #: Scattering at 440 nm. [1/m; 0 to 100]
    scattering440: float | None = _field(None, '1/m', 0, 100)
    #: Mean cosine of scattering (Henyey and Greenstein's g) at 680 nm; read
    #: with the coefficients only, and not with backscatter_ratio. [1; 0 to
    #: 0.98]
    asymmetry680: float = _field(0.924, '1', 0, 0.98)
    #: The same at 550 nm. [1; 0 to 0.98]
    asymmetry550: float = _field(0.924, '1', 0, 0.98)
    #: The same at 440 nm. [1; 0 to 0.98]
    asymmetry440: float = _field(0.924, '1', 0, 0.98)
    #: Depth, the same everywhere. [m; 0.1 to 11000]
    depth: float = _field(1000.0, 'm', 0.1, 11000)
    #: What the bottom is.
    #: One of BLACK, SAND, MUD, ROCK, CORAL.
    bottom: str = _field('BLACK',
        words="BLACK SAND MUD ROCK CORAL")
    #: Albedo of the bottom at 680 nm; with the other two, instead of bottom.
    #: [1; 0 to 1]
    albedo680: float | None = _field(None, '1', 0, 1)
    #: Albedo at 550 nm. [1; 0 to 1]
    albedo550: float | None = _field(None, '1', 0, 1)
    #: Albedo at 440 nm. [1; 0 to 1]
    albedo440: float | None = _field(None, '1', 0, 1)
    #: Orders of scattering to draw.
    #: One of ALL, TWO, PAPER, SINGLE.
    orders: str = _field('ALL',
        words="ALL TWO PAPER SINGLE")
    #: Salinity: with the temperature, what the water itself scatters and what
    #: its surface reflects. [g/kg; 0 to 42]
    salinity: float = _field(35.0, 'g/kg', 0, 42)
    #: Temperature. [degC; -2 to 40]
    temperature: float = _field(15.0, 'degC', -2, 40)
    #: Absorption of dissolved matter at 440 nm, with chlorophyll; absent: a
    #: fifth of what water and algae absorb there. [1/m; 0 to 20]
    cdom: float | None = _field(None, '1/m', 0, 20)
    #: How fast it falls with wavelength. [1/nm; 0.005 to 0.03]
    cdomSlope: float = _field(0.014, '1/nm', 0.005, 0.03)
    #: Absorption at 440 nm of particles that are not algae, with chlorophyll;
    #: absent: 0.0124 chlorophyll^0.724. [1/m; 0 to 20]
    detritus: float | None = _field(None, '1/m', 0, 20)
    #: How fast it falls with wavelength. [1/nm; 0.005 to 0.03]
    detritusSlope: float = _field(0.011, '1/nm', 0.005, 0.03)
    #: Suspended minerals, with chlorophyll: they absorb and scatter besides
    #: all else. [g/m3; 0 to 100]
    minerals: float = _field(0.0, 'g/m3', 0, 100)
    #: Backscattered fraction of what particles scatter; absent: by
    #: chlorophyll, or the known water's. [1; 0.001 to 0.06]
    backscatterRatio: float | None = _field(None, '1', 0.001, 0.06)
    #: How particles turn light; water itself does by Rayleigh's function. With
    #: coefficients and without backscatter_ratio: HENYEY_GREENSTEIN.
    #: One of FOURNIER_FORAND, HENYEY_GREENSTEIN.
    phase: str = _field('FOURNIER_FORAND',
        words="FOURNIER_FORAND HENYEY_GREENSTEIN")
    #: Raman scattering by the water: some light of shorter waves becomes green
    #: and red. With orders ALL.
    raman: bool = _field(True)
    #: Suspended particles of more than 0.5 mm, marine snow, that an eye under
    #: water sees one by one, sinking and swaying with the waves; their light
    #: is not in the water's own. Clear water has some hundred, coastal water
    #: thousands. [1/m3; 0 to 50000]
    particles: float = _field(0.0, '1/m3', 0, 50000)
    #: Their number by diameter d falls as d^-this. [1; 2.5 to 6]
    particleExponent: float = _field(4.0, '1', 2.5, 6)
    #: The largest of them. [mm; 1 to 30]
    particleLargest: float = _field(8.0, 'mm', 1, 30)


@dataclass(frozen=True)
class Fog(Record):
    """Fog or haze: a layer everywhere, or a bank. What it takes of the light
    comes on top of what the air takes (sky.visibility)."""
    #: Visibility inside: there a black thing before the horizon keeps 2 % of
    #: its contrast (Koschmieder). [m; 20 to 100000]
    visibility: float = _field(500.0, 'm', 20, 100000)
    #: Height where it begins; 0: on the sea. A bank that begins above is a
    #: lens, else a dome. [m; 0 to 10000]
    bottom: float = _field(0.0, 'm', 0, 10000)
    #: Height of its top, of a bank in its middle. [m; 2 to 12000]
    top: float = _field(80.0, 'm', 2, 12000)
    #: Height over which a layer thins out about its bottom and top. [m; 1 to
    #: 2000]
    edge: float = _field(20.0, 'm', 1, 2000)
    #: Radius of a bank, at which there is nothing left of it; absent: a layer,
    #: everywhere. [m; 50 to 20000]
    radius: float | None = _field(None, 'm', 50, 20000)
    #: Geodetic latitude of a bank's middle; absent: the origin's. [deg; -90 to
    #: 90]
    latitude: float | None = _field(None, 'deg', -90, 90)
    #: Its longitude; absent: the origin's. [deg; -180 to 180]
    longitude: float | None = _field(None, 'deg', -180, 180)
    #: Speed at which a bank drifts; absent: sea.windSpeed. [m/s; 0 to 50]
    speed: float | None = _field(None, 'm/s', 0, 50)
    #: Direction it comes from; absent: sea.windDirection. [deg; 0 to 360]
    direction: float | None = _field(None, 'deg', 0, 360)
    #: Simulated time at which it is at its place. [s; -1000000000 to
    #: 1000000000]
    time: float = _field(0.0, 's', -1000000000, 1000000000)


@dataclass(frozen=True)
class Sky(Record):
    """What is given of Sun and Moon holds at the origin; views elsewhere have
    them as they stand there."""
    #: Azimuth of the Sun; absent: from clock.utc and origin. [deg; 0 to 360]
    sunAzimuth: float | None = _field(None, 'deg', 0, 360)
    #: Elevation of the Sun; absent: from clock.utc and origin. [deg; -90 to
    #: 90]
    sunElevation: float | None = _field(None, 'deg', -90, 90)
    #: Meteorological visibility near the sea. [m; 200 to 300000]
    visibility: float = _field(40000.0, 'm', 200, 300000)
    #: Azimuth of the Moon; absent: from clock.utc and origin. [deg; 0 to 360]
    moonAzimuth: float | None = _field(None, 'deg', 0, 360)
    #: Elevation of the Moon; absent: from clock.utc and origin, or where
    #: sunElevation is set: no Moon. [deg; -90 to 90]
    moonElevation: float | None = _field(None, 'deg', -90, 90)
    #: Share of the Moon's disc that is lit, 1 at full Moon; absent: from
    #: clock.utc. Its bright limb is on the Sun's side. [1; 0 to 1]
    moonPhase: float | None = _field(None, '1', 0, 1)
    #: Stars, planets, airglow, zodiacal light and Milky Way, by clock.utc and
    #: origin, once the Sun is 1 degree below the horizon.
    stars: bool = _field(True)
    #: Share of the sea that clouds cover, seen from above; 0: no clouds.
    #: [okta; 0 to 8]
    cloudCover: float = _field(0.0, 'okta', 0, 8)
    #: What clouds they are.
    #: One of CUMULUS, STRATOCUMULUS, STRATUS, NIMBOSTRATUS, ALTOCUMULUS,
    #: ALTOSTRATUS, CIRRUS, CUMULONIMBUS.
    cloudGenus: str = _field('CUMULUS',
        words="CUMULUS STRATOCUMULUS STRATUS NIMBOSTRATUS ALTOCUMULUS "
        "ALTOSTRATUS CIRRUS CUMULONIMBUS")
    #: Height of their base; absent: the genus's own. [m; 30 to 12000]
    cloudBase: float | None = _field(None, 'm', 30, 12000)
    #: Their thickness where it is greatest; absent: the genus's own. [m; 50 to
    #: 12000]
    cloudThickness: float | None = _field(None, 'm', 50, 12000)
    #: Speed at which they drift; absent: 1.5 times sea.windSpeed. [m/s; 0 to
    #: 100]
    cloudSpeed: float | None = _field(None, 'm/s', 0, 100)
    #: Direction that they come from; absent: sea.windDirection. [deg; 0 to
    #: 360]
    cloudDirection: float | None = _field(None, 'deg', 0, 360)
    #: Other clouds of the same kind. [1; 0 to 65535]
    cloudSeed: int = _field(1, '1', 0, 65535)
    #: Picture in the directory of pelagosd --panoramas that stands for the
    #: whole sky, by day and night, without Moon and stars: OpenEXR or Radiance
    #: .hdr, linear Rec. 709, of equal steps of azimuth and elevation, twice as
    #: wide as high, horizon in the middle; absent: the computed sky. [at most
    #: 512 bytes]
    file: str | None = _field(None)
    #: Luminance of the value 1 in the picture. [cd/m2; 1e-06 to 1000000]
    fileScale: float = _field(179.0, 'cd/m2', 1e-06, 1000000)
    #: Fog and haze in layers and banks, at most 4.
    fog: tuple[Fog, ...] = ()
    #: METAR or SPECI of an aerodrome, as "EHAM 231355Z 24015KT 4000 -RA BKN012
    #: 12/09 Q1003": sets wind, visibility, fog, rain, snow and clouds by it;
    #: not kept. [at most 512 bytes]
    metar: str | None = _field(None)
    #: Rain: it takes visibility, raises ring waves, and calms short waves and
    #: whitecaps. [mm/h; 0 to 150]
    rain: float = _field(0.0, 'mm/h', 0, 150)
    #: Snow, as water: it takes visibility, down to 200 m. [mm/h; 0 to 10]
    snow: float = _field(0.0, 'mm/h', 0, 10)
    #: Lightning: flashes from the clouds' base to the sea; three times as many
    #: stay within the clouds, where there are some. [1/min; 0 to 60]
    lightning: float = _field(0.0, '1/min', 0, 60)
    #: Radius of the storm about its middle. [m; 100 to 50000]
    lightningRadius: float = _field(8000.0, 'm', 100, 50000)
    #: Geodetic latitude of the storm's middle; absent: the origin's. [deg; -90
    #: to 90]
    lightningLatitude: float | None = _field(None, 'deg', -90, 90)
    #: Its longitude; absent: the origin's. [deg; -180 to 180]
    lightningLongitude: float | None = _field(None, 'deg', -180, 180)
    #: Compass direction of the picture's middle; right of it is clockwise.
    #: [deg; 0 to 360]
    fileAzimuth: float = _field(0.0, 'deg', 0, 360)
    #: One of APART, IN_THE_PICTURE, NONE_SEEN.
    fileSun: str = _field('APART',
        words="APART IN_THE_PICTURE NONE_SEEN")


@dataclass(frozen=True)
class Model(Record):
    """The shape of an entity, drawn on the sea."""
    #: A built-in model (`tanker`), or a file of the directory of pelagosd
    #: --models (`ferry/ferry.glb`): GET /v1/models lists both. [at most 512
    #: bytes]
    name: str | None = _field(None)
    #: Length over all; absent: the model's own. What is absent of the next
    #: three follows it. [m; 0.1 to 1000]
    length: float | None = _field(None, 'm', 0.1, 1000)
    #: Breadth. [m; 0.1 to 1000]
    beam: float | None = _field(None, 'm', 0.1, 1000)
    #: Of the keel below the waterline; only of built-in models. [m; 0.01 to
    #: 100]
    draught: float | None = _field(None, 'm', 0.01, 100)
    #: Of the highest point above the waterline; only of built-in models. [m;
    #: 0.1 to 1000]
    height: float | None = _field(None, 'm', 0.1, 1000)
    #: Colour of a built-in model's hull: sRGB, 65536 red + 256 green + blue.
    #: [1; 0 to 16777215]
    colour: int | None = _field(None, '1', 0, 16777215)


@dataclass(frozen=True)
class OwnShip(Record):
    """Own ship for when no simulator gives its poses: orders move the entity,
    and the sea that is drawn heaves, pitches and rolls it
    (docs/physics/ships.md). While `on`, the entity's pose is the model's. A
    patch that gives the entity a pose or a rate without giving `on` turns it
    off: another leads."""
    #: Whether the model moves the entity.
    on: bool = _field(False)
    #: The entity that it moves; of `helm` the one that has it. [1; 0 to 65535]
    entity: int = _field(1, '1', 0, 65535)
    #: Rudder, positive turns to starboard. [deg; -45 to 45]
    rudder: float = _field(0.0, 'deg', -45, 45)
    #: Engine: 1 full ahead, -1 full astern. [1; -1 to 1]
    throttle: float = _field(0.0, '1', -1, 1)
    #: Length of the waterline. [m; 3 to 500]
    length: float = _field(40.0, 'm', 3, 500)
    #: Breadth of the waterline. [m; 1 to 80]
    beam: float = _field(9.0, 'm', 1, 80)
    #: Speed at full throttle. [m/s; 0.5 to 50]
    maxSpeed: float = _field(8.0, 'm/s', 0.5, 50)
    #: Time constant of the speed. [s; 1 to 1000]
    surgeTime: float = _field(20.0, 's', 1, 1000)
    #: Nomoto's K': turn rate over rudder, times length over speed. [1; 0.1 to
    #: 10]
    turnGain: float = _field(1.5, '1', 0.1, 10)
    #: Nomoto's T': time constant of turning, times speed over length. [1; 0.1
    #: to 20]
    turnTime: float = _field(1.5, '1', 0.1, 20)
    #: Natural period of heave; absent: from the beam. [s; 0.5 to 60]
    heavePeriod: float | None = _field(None, 's', 0.5, 60)
    #: Natural period of pitch; absent: as heave from the beam. [s; 0.5 to 60]
    pitchPeriod: float | None = _field(None, 's', 0.5, 60)
    #: Natural period of roll; absent: from the beam. [s; 0.5 to 60]
    rollPeriod: float | None = _field(None, 's', 0.5, 60)
    #: Damping of roll, of critical. [1; 0.01 to 0.95]
    rollDamping: float = _field(0.1, '1', 0.01, 0.95)
    #: Rates of the motion in waves, kept by the server so that it goes on
    #: after a restart and in a replay. [m/s; -100 to 100]
    heaveRate: float = _field(0.0, 'm/s', -100, 100)
    #:  [deg/s; -1000 to 1000]
    pitchRate: float = _field(0.0, 'deg/s', -1000, 1000)
    #:  [deg/s; -1000 to 1000]
    rollRate: float = _field(0.0, 'deg/s', -1000, 1000)


@dataclass(frozen=True)
class TrackPoint(Record):
    """A place of an entity in the past."""
    #: Simulated time. [s; 0 to 1000000000]
    time: float = _field(0.0, 's', 0, 1000000000)
    #: Geodetic latitude. [deg; -90 to 90]
    latitude: float = _field(0.0, 'deg', -90, 90)
    #: Longitude. [deg; -180 to 180]
    longitude: float = _field(0.0, 'deg', -180, 180)
    #: True heading, while `wash`. [deg; 0 to 360]
    heading: float | None = _field(None, 'deg', 0, 360)
    #: What the screw pushed from there on: the speed at which that is the
    #: drag, negative astern; absent: that of the ship. [m/s; -50 to 50]
    push: float | None = _field(None, 'm/s', -50, 50)


@dataclass(frozen=True)
class LightSector(Record):
    """A sector of a mark's light."""
    #: What is seen there.
    #: One of LIGHT_WHITE, LIGHT_RED, LIGHT_GREEN, LIGHT_YELLOW, LIGHT_BLUE.
    colour: str = _field('LIGHT_WHITE',
        words="LIGHT_WHITE LIGHT_RED LIGHT_GREEN LIGHT_YELLOW LIGHT_BLUE")
    #: It begins at this true bearing, from seaward as charts have it. [deg; 0
    #: to 360]
    begin: float = _field(0.0, 'deg', 0, 360)
    #: Clockwise to this one; the same: all round. [deg; 0 to 360]
    end: float = _field(0.0, 'deg', 0, 360)
    #: Nominal range; absent: the light's. [nmi; 0.1 to 40]
    range: float | None = _field(None, 'nmi', 0.1, 40)


@dataclass(frozen=True)
class Light(Record):
    """The light of a mark, or any other that has a rhythm."""
    #: Rhythm, colours and period as charts write them: "Fl(2) R 10s",
    #: "Q(6)+LFl 15s", "Iso 4s", "VQ", "F Y", "Mo(A) 8s", "Al.WR 6s"; absent:
    #: by the class of the model, as IALA has it. docs/lights.md.
    character: str | None = _field(None)
    #: Nominal range: seen so far where a mile of air lets 0.74 through;
    #: absent: the model's, or 5. [nmi; 0.1 to 40]
    range: float | None = _field(None, 'nmi', 0.1, 40)
    #: Height above the entity's place; absent: where its model has a light, or
    #: its highest point; without a model 10 m. [m; -1000 to 1000]
    height: float | None = _field(None, 'm', -1000, 1000)
    #: When a period begins, after whole periods since 1970 (UTC); absent: by
    #: the entity's id, so that marks do not flash as one. [s; 0 to 300]
    phase: float | None = _field(None, 's', 0, 300)
    #: The arcs in which it is seen, at most 12; none: all round. Of a
    #: character of several colours (not Al) each has one, or more.
    sectors: tuple[LightSector, ...] = ()


@dataclass(frozen=True)
class Searchlight(Record):
    """A searchlight: a beam that goes where it is pointed."""
    #: Whether it is lit.
    on: bool = _field(False)
    #: From the bow, clockwise. [deg; -360 to 360]
    bearing: float = _field(0.0, 'deg', -360, 360)
    #: Above the deck's level. [deg; -90 to 90]
    elevation: float = _field(-2.0, 'deg', -90, 90)
    #: Of the whole beam, to half its strength. [deg; 0.5 to 90]
    width: float = _field(3.0, 'deg', 0.5, 90)
    #: In its middle. [cd; 1 to 1000000000]
    intensity: float = _field(1000000.0, 'cd', 1, 1000000000)


@dataclass(frozen=True)
class SignalLamp(Record):
    """A signal lamp: Morse, once."""
    #: What it says; letters, digits, spaces and . , ? ' / : = + -
    text: str | None = _field(None)
    #: Simulated time at which it begins. [s; 0 to 1000000000]
    start: float = _field(0.0, 's', 0, 1000000000)
    #: Words a minute, as the word PARIS. [1; 1 to 40]
    speed: float = _field(8.0, '1', 1, 40)
    #: From the bow, clockwise: a daylight signalling lamp of 60,000 cd that
    #: points there; absent: a white light all round of 5 nautical miles. [deg;
    #: -360 to 360]
    bearing: float | None = _field(None, 'deg', -360, 360)


@dataclass(frozen=True)
class Entity(Record):
    """A body that moves: own ship, target, buoy. Its pose is given at poseTime
    and reckoned onward from speed, course and turn rate."""
    #: Number that names the entity. [0 to 65535]
    id: int | None = _field(None, None, 0, 65535)
    #: Name for people; also accepted in paths where it is unique.
    name: str | None = _field(None)
    #: Geodetic latitude. [deg; -90 to 90]
    latitude: float = _field(52.6, 'deg', -90, 90)
    #: Longitude. [deg; -180 to 180]
    longitude: float = _field(5.2, 'deg', -180, 180)
    #: Height of the reference point above mean sea level. [m; -100 to 20000]
    altitude: float = _field(0.0, 'm', -100, 20000)
    #: True heading. [deg; 0 to 360]
    heading: float = _field(0.0, 'deg', 0, 360)
    #: Pitch, bow up positive (trim). [deg; -90 to 90]
    pitch: float = _field(0.0, 'deg', -90, 90)
    #: Roll, starboard down positive (heel). [deg; -180 to 180]
    roll: float = _field(0.0, 'deg', -180, 180)
    #: Speed over ground. [m/s; 0 to 200]
    speed: float = _field(0.0, 'm/s', 0, 200)
    #: Course over ground. [deg; 0 to 360]
    course: float = _field(0.0, 'deg', 0, 360)
    #: Rate of turn, to starboard positive. [deg/s; -90 to 90]
    turnRate: float = _field(0.0, 'deg/s', -90, 90)
    #: Simulated time of this pose; set by the server when absent. [s; 0 to
    #: 1000000000]
    poseTime: float | None = _field(None, 's', 0, 1000000000)
    #: Rate of climb. [m/s; -200 to 200]
    climbRate: float = _field(0.0, 'm/s', -200, 200)
    #: Rate of pitch, bow up positive. [deg/s; -90 to 90]
    pitchRate: float = _field(0.0, 'deg/s', -90, 90)
    #: Rate of roll, starboard down positive. [deg/s; -90 to 90]
    rollRate: float = _field(0.0, 'deg/s', -90, 90)
    #: Its shape; absent: it has none.
    model: Model | None = _field(None)
    #: Height, pitch and roll are the sea's at its hull instead of the pose's,
    #: where it has a model and no helm moves it.
    afloat: bool = _field(False)
    #: A helm of its own: what ownShip is to one ship, for further ones. At
    #: most 8 may be `on`, ownShip's among them, and one for each entity.
    helm: OwnShip | None = _field(None)
    #: Afloat, it drifts downwind with this share of the wind's speed besides
    #: its own speed, for as long as nobody gives it another pose: about 0.01 a
    #: person, 0.03 a boat or a life raft. [1; 0 to 0.2]
    leeway: float = _field(0.0, '1', 0, 0.2)
    #: Afloat, it is moored at its latitude and longitude, and swings within
    #: this radius, a vessel head to wind; 0: it is not moored. [m; 0 to 1000]
    mooring: float = _field(0.0, 'm', 0, 1000)
    #: Whether it makes waves as it moves, where it has a model.
    wake: bool = _field(False)
    #: Where it was, written by the server while `wake` or `wash`, oldest
    #: first, at most 240; its poses go on from there.
    track: tuple[TrackPoint, ...] = ()
    #: Whether it leaves a wash, where it has a model or a helm: foam at the
    #: bow and from the screw, a turbulent wake in which short waves are lower
    #: for minutes, bubbles. The screw pushes as the helm's throttle orders,
    #: without one as its speed asks.
    wash: bool = _field(False)
    #: When the lights are lit that its model asks for: of a vessel those of
    #: COLREGS by its length and navigationStatus, of a mark its `light`.
    #: One of OFF, AUTO, ON.
    lights: str = _field('OFF',
        words="OFF AUTO ON")
    #: What it does, as its lights say it and AIS.
    #: One of UNDER_WAY, AT_ANCHOR, NOT_UNDER_COMMAND, RESTRICTED, CONSTRAINED,
    #: MOORED, AGROUND, FISHING, SAILING, TOWING, PUSHING, UNDEFINED, TRAWLING,
    #: PILOTING, TOWED, ROWING.
    navigationStatus: str = _field('UNDEFINED',
        words="UNDER_WAY AT_ANCHOR NOT_UNDER_COMMAND RESTRICTED CONSTRAINED "
        "MOORED AGROUND FISHING SAILING TOWING PUSHING UNDEFINED "
        "TRAWLING PILOTING TOWED ROWING")
    #: Of a mark, or of a place without a model.
    light: Light | None = _field(None)
    #: Lamps above its decks.
    deckLights: bool = _field(False)
    #: Its searchlight.
    searchlight: Searchlight | None = _field(None)
    #: Its signal lamp.
    signal: SignalLamp | None = _field(None)
    #: Of one that tows: from its stern to the end of the tow. [m; 0 to 5000]
    towLength: float = _field(150.0, 'm', 0, 5000)


@dataclass(frozen=True)
class Frustum(Record):
    """Angles from the camera's axis to the edges of the picture; all four must
    be given, left < right and bottom < top, at least 0.01 deg apart."""
    #: To the left edge, negative left of the axis. [deg; -80 to 80]
    left: float | None = _field(None, 'deg', -80, 80)
    #: To the right edge. [deg; -80 to 80]
    right: float | None = _field(None, 'deg', -80, 80)
    #: To the top edge. [deg; -80 to 80]
    top: float | None = _field(None, 'deg', -80, 80)
    #: To the bottom edge. [deg; -80 to 80]
    bottom: float | None = _field(None, 'deg', -80, 80)


@dataclass(frozen=True)
class Sensor(Record):
    """What a sensor shows. Of kind VISIBLE: the eye's luminance as displayed,
    times 4^(2 gain - 1), plus level - 0.5."""
    #: No: no picture, black.
    on: bool = _field(True)
    #: Bright is dark: the negative.
    blackHot: bool = _field(False)
    #: gain and level are left to the exposure.
    autoGain: bool = _field(False)
    #: Contrast. [1; 0 to 1]
    gain: float = _field(0.5, '1', 0, 1)
    #: Brightness. [1; 0 to 1]
    level: float = _field(0.5, '1', 0, 1)
    #: Grain: the most it adds or takes, of white. [1; 0 to 1]
    noise: float = _field(0.0, '1', 0, 1)
    #: One line in 64, another with each moment, is black.
    dropout: bool = _field(False)
    #: What it sees.
    #: One of VISIBLE, LOW_LIGHT, THERMAL.
    kind: str = _field('VISIBLE',
        words="VISIBLE LOW_LIGHT THERMAL")
    #: Low light: how long it counts photons. [s; 1e-05 to 1]
    exposureTime: float = _field(0.033, 's', 1e-05, 1)
    #: Low light: focal length over the lens's opening. [1; 0.7 to 32]
    fNumber: float = _field(1.4, '1', 0.7, 32)
    #: Low light: what the screen glows in.
    #: One of GREY, GREEN, WHITE.
    phosphor: str = _field('GREY',
        words="GREY GREEN WHITE")
    #: Thermal: temperatures from black to white; absent: 20 K times 4^(1 - 2
    #: gain), or with autoGain by sky, air and sea. [K; 0.5 to 300]
    span: float | None = _field(None, 'K', 0.5, 300)
    #: Thermal: standard deviation of a pixel's temperature (NETD). [K; 0 to 5]
    netd: float = _field(0.05, 'K', 0, 5)
    #: Thermal: the air's temperature; absent: the water's. [degC; -60 to 60]
    airTemperature: float | None = _field(None, 'degC', -60, 60)
    #: Thermal: the air's relative humidity. [1; 0 to 1]
    humidity: float = _field(0.75, '1', 0, 1)
    #: Thermal: share of the sky's coldness that clouds take. [1; 0 to 1]
    cloud: float = _field(0.0, '1', 0, 1)


@dataclass(frozen=True)
class Radar(Record):
    """A navigation radar of 3.2 cm whose antenna stands at the view's place: a
    plan position indicator."""
    #: Range at the picture's edge. [nmi; 0.125 to 96]
    range: float = _field(6.0, 'nmi', 0.125, 96)
    #:  [1; 0 to 1]
    gain: float = _field(0.5, '1', 0, 1)
    #: Suppression of clutter from the sea: of what is near. [1; 0 to 1]
    stc: float = _field(0.6, '1', 0, 1)
    #: Suppression of clutter from rain: of what is as bright as what lies
    #: before it. [1; 0 to 1]
    ftc: float = _field(0.0, '1', 0, 1)
    #: Length of pulses; absent: 0.08 us to 3 nmi, 0.3 to 12, 0.8 beyond. [us;
    #: 0.03 to 1.5]
    pulse: float | None = _field(None, 'us', 0.03, 1.5)
    #: Width of the beam. [deg; 0.3 to 6]
    beamWidth: float = _field(1.2, 'deg', 0.3, 6)
    #: Turns of the antenna. [1/min; 6 to 60]
    rotation: float = _field(24.0, '1/min', 6, 60)
    #: North at the top; else the heading of the entity that carries it.
    northUp: bool = _field(False)
    #: Rings of range, a sixth of it apart.
    rings: bool = _field(True)
    #: Rain; absent: sky.rain. [mm/h; 0 to 200]
    rain: float | None = _field(None, 'mm/h', 0, 200)


@dataclass(frozen=True)
class Place(Record):
    """A place where a camera stands: both of latitude and longitude."""
    #: Geodetic latitude. [deg; -90 to 90]
    latitude: float | None = _field(None, 'deg', -90, 90)
    #: Longitude. [deg; -180 to 180]
    longitude: float | None = _field(None, 'deg', -180, 180)
    #: Height above altitude 0; absent: View.up. [m; -100 to 10000000]
    height: float | None = _field(None, 'm', -100, 10000000)


@dataclass(frozen=True)
class LookAt(Record):
    """What a camera looks at: all of latitude and longitude, or an entity."""
    #: Geodetic latitude. [deg; -90 to 90]
    latitude: float | None = _field(None, 'deg', -90, 90)
    #: Longitude. [deg; -180 to 180]
    longitude: float | None = _field(None, 'deg', -180, 180)
    #: Height above altitude 0; of an entity: above its reference point. [m;
    #: -10000 to 10000000]
    height: float = _field(0.0, 'm', -10000, 10000000)
    #: Entity instead. [1; 0 to 65535]
    entity: int | None = _field(None, '1', 0, 65535)


@dataclass(frozen=True)
class Orbit(Record):
    """A camera that circles about a place (both of latitude and longitude) or
    an entity and looks at it. Its place is a function of simulated time
    alone."""
    #: Geodetic latitude of the middle. [deg; -90 to 90]
    latitude: float | None = _field(None, 'deg', -90, 90)
    #: Its longitude. [deg; -180 to 180]
    longitude: float | None = _field(None, 'deg', -180, 180)
    #: Its height above altitude 0; of an entity: above its reference point,
    #: which does not heave with the sea. [m; -100 to 1000000]
    height: float = _field(0.0, 'm', -100, 1000000)
    #: Entity in the middle instead. [1; 0 to 65535]
    entity: int | None = _field(None, '1', 0, 65535)
    #: Straight distance from the middle. [m; 1 to 10000000]
    radius: float = _field(500.0, 'm', 1, 10000000)
    #: How high the camera stands over the middle's horizon. [deg; 0 to 90]
    elevation: float = _field(15.0, 'deg', 0, 90)
    #: True bearing of the camera from the middle at simulated time 0. [deg;
    #: -360 to 360]
    azimuth: float = _field(180.0, 'deg', -360, 360)
    #: Time of a turn, clockwise as seen from above, negative: the other way;
    #: absent: it stands at its azimuth. [s; -1000000 to 1000000]
    period: float | None = _field(None, 's', -1000000, 1000000)


@dataclass(frozen=True)
class Satellite(Record):
    """A camera on the circle of a satellite, over an Earth that turns below
    it: its heading is that of its way over the ground. Its place is a function
    of simulated time alone."""
    #: Between the circle and the equator; above 90 it goes westward. [deg; 0
    #: to 180]
    inclination: float = _field(51.6, 'deg', 0, 180)
    #: Longitude where it crosses the equator northward, at simulated time 0.
    #: [deg; -180 to 180]
    node: float = _field(0.0, 'deg', -180, 180)
    #: How far it is past that point at simulated time 0, along the circle.
    #: [deg; -360 to 360]
    phase: float = _field(0.0, 'deg', -360, 360)
    #: Height above the ellipsoid. [m; 1000 to 10000000]
    height: float = _field(400000.0, 'm', 1000, 10000000)
    #: Time of a revolution; absent: Kepler's at this height. [s; 60 to
    #: 1000000]
    period: float | None = _field(None, 's', 60, 1000000)


@dataclass(frozen=True)
class Waypoint(Record):
    """Where a camera is at a moment of its way; both of latitude and
    longitude."""
    #: Simulated time, later than that of the waypoint before. [s; 0 to
    #: 1000000000]
    time: float = _field(0.0, 's', 0, 1000000000)
    #: Geodetic latitude. [deg; -90 to 90]
    latitude: float | None = _field(None, 'deg', -90, 90)
    #: Longitude. [deg; -180 to 180]
    longitude: float | None = _field(None, 'deg', -180, 180)
    #: Height above altitude 0. [m; -100 to 10000000]
    height: float = _field(10.0, 'm', -100, 10000000)
    #: True heading. [deg; -360 to 360]
    heading: float = _field(0.0, 'deg', -360, 360)
    #: Upward. [deg; -90 to 90]
    pitch: float = _field(0.0, 'deg', -90, 90)
    #: Right side down. [deg; -180 to 180]
    roll: float = _field(0.0, 'deg', -180, 180)


@dataclass(frozen=True)
class View(Record):
    """One camera. Where it stands is said by one of entity, at, orbit,
    satellite and waypoints; without any it is the origin with heading 0.
    Whither it looks follows from that (an entity's bow, true north of `at`,
    the middle of an orbit, the way of a satellite, heading, pitch and roll of
    waypoints), or from lookAt, which comes before it and holds the horizon
    level. Then yaw, pitch and roll turn it, in this order: with all of them 0
    what it looks at is in the middle. forward and right are relative to the
    entity or to the origin, and do not count with at, orbit, satellite and
    waypoints; up is also the height of `at`, where that gives none."""
    #: Name, 1 to 64 of A-Z a-z 0-9 _ -.
    name: str | None = _field(None)
    #: Entity the camera is fixed to; absent: the world. [1; 0 to 65535]
    entity: int | None = _field(None, '1', 0, 65535)
    #: Camera position towards the bow (north without entity). [m; -100000 to
    #: 100000]
    forward: float = _field(0.0, 'm', -100000, 100000)
    #: Camera position to starboard (east without entity). [m; -100000 to
    #: 100000]
    right: float = _field(0.0, 'm', -100000, 100000)
    #: Camera position upward from the reference point. [m; -100 to 10000000]
    up: float = _field(10.0, 'm', -100, 10000000)
    #: Direction of sight, to starboard of the bow. [deg; -360 to 360]
    yaw: float = _field(0.0, 'deg', -360, 360)
    #: Direction of sight, upward. [deg; -90 to 90]
    pitch: float = _field(0.0, 'deg', -90, 90)
    #: Roll of the camera, its right side down positive. [deg; -180 to 180]
    roll: float = _field(0.0, 'deg', -180, 180)
    #: Horizontal field of view of a symmetric frustum. [deg; 1 to 150]
    fieldOfView: float = _field(60.0, 'deg', 1, 150)
    #: Off-axis frustum; replaces fieldOfView.
    frustum: Frustum | None = _field(None)
    #: Width of the picture. [px; 16 to 4096]
    width: int = _field(1280, 'px', 16, 4096)
    #: Height of the picture. [px; 16 to 4096]
    height: int = _field(720, 'px', 16, 4096)
    #: Exposure as EV100; absent: metered by what the view sees. [EV; -10 to
    #: 24]
    exposure: float | None = _field(None, 'EV', -10, 24)
    #: A sensor's picture instead of the eye's; absent: the eye's. Of eight
    #: bits a channel; linear layers are what they are.
    sensor: Sensor | None = _field(None)
    #: Curve from light to screen, of the eye's picture and of the sensor's.
    #: One of FILMIC, LINEAR.
    tone: str = _field('FILMIC',
        words="FILMIC LINEAR")
    #: Name of a meter, 1 to 64 of A-Z a-z 0-9 _ -: views that name the same,
    #: 12 at most, are exposed alike, by what all of them see, so that they
    #: match side by side, as far as they stand within the same kilometre and
    #: so have the same light; absent: by what this view sees.
    meter: str | None = _field(None)
    #: Share of the Sun's light that the lens scatters around it: glare. A good
    #: lens has 0.01, an eye some 0.1. [1; 0 to 0.5]
    glare: float = _field(0.01, '1', 0, 0.5)
    #: Pixels that crests, the horizon or the Sun's rim cut show the mean of
    #: what is on either side, before exposure; false: what their middle sees.
    antialiasing: bool = _field(True)
    #: The entity carries the camera by its place and heading alone: its pitch
    #: and roll neither move nor tilt it, as for a camera that follows a ship.
    level: bool = _field(False)
    #: Who looks. Glare of an eye is some 0.1 (glare).
    #: One of CAMERA, EYE.
    vision: str = _field('CAMERA',
        words="CAMERA EYE")
    #: How long the shutter is open, for streaks of rain and snow: a fast one
    #: shows them short and bright. A low-light sensor has its own. [s; 0.0005
    #: to 0.25]
    shutter: float = _field(0.016666666666666666, 's', 0.0005, 0.25)
    #: Drops on a pane half a metre before the camera, which sit, are hit anew
    #: and run down, as in rain or spray: how much of them. [1; 0 to 1]
    wetLens: float = _field(0.0, '1', 0, 1)
    #: A radar's picture instead of the eye's, of the view's size; its antenna
    #: stands at the view's place.
    radar: Radar | None = _field(None)
    #: It stands at a place on Earth.
    at: Place | None = _field(None)
    #: It looks at a place or an entity.
    lookAt: LookAt | None = _field(None)
    #: It circles about a place or an entity.
    orbit: Orbit | None = _field(None)
    #: It goes with a satellite.
    satellite: Satellite | None = _field(None)
    #: It goes a way, at most 64 waypoints: from each to the next on a smooth
    #: curve, its height evenly by its logarithm, and stands before the first
    #: and after the last. A patch replaces all of them.
    waypoints: tuple[Waypoint, ...] = ()


@dataclass(frozen=True)
class Sources(Record):
    """Inputs that led and have fallen silent. The server sets and clears them
    as it notices, and a client may, for a source of its own. At a start none
    is stale."""
    #: Whether pictures say so: an amber border, STALE and the input's name, or
    #: POSES where a moving entity has no new pose (clock.reckoning). EXR
    #: layers stay as they are.
    mark: bool = _field(False)
    #: The CIGI host (--cigi) has been silent for 2 s.
    cigiStale: bool = _field(False)
    #: The heartbeat register of a Modbus unit has been silent (--modbus-
    #: heartbeat).
    modbusStale: bool = _field(False)
    #: NMEA 0183 had a position and has had none for 10 s.
    nmeaStale: bool = _field(False)
    #: The console that is polled (--console) does not answer.
    consoleStale: bool = _field(False)
    #: A source of a client's own.
    otherStale: bool = _field(False)


@dataclass(frozen=True)
class Seabed(Record):
    """The bottom as a height field, with the land beside it. Light in the
    water and soundings follow it; the waves keep to sea.depth. water.bottom or
    the albedos say what it is made of, seabed.land the land; beyond the field
    water.depth holds."""
    #: File in the directory of pelagosd --bathymetry: GeoTIFF, NetCDF
    #: (EMODnet, GEBCO), HDF5, BAG, ENVI, ESRI .hdr or ASCII grid, or OpenEXR,
    #: that needs no file of another name; absent: water.depth everywhere. Of
    #: more than 2048 x 2048 heights those about the origin are taken. [at most
    #: 512 bytes]
    file: str | None = _field(None)
    #: Which way the file's numbers grow, where it does not say it itself by
    #: standard_name, positive, its vertical CRS or its format: a file of
    #: depths is read as such; DEPTH for a file of heights is refused. Units
    #: are the file's.
    #: One of ELEVATION, DEPTH.
    values: str = _field('ELEVATION',
        words="ELEVATION DEPTH")
    #: Of the file's zero (chart datum) above mean sea level. [m; -100 to 100]
    offset: float = _field(0.0, 'm', -100, 100)
    #: Latitude of the field's middle; with the next two, for a file that has
    #: no georeference. [deg; -85 to 85]
    latitude: float | None = _field(None, 'deg', -85, 85)
    #: Longitude of its middle. [deg; -180 to 180]
    longitude: float | None = _field(None, 'deg', -180, 180)
    #: Distance of its pixels. [m; 0.1 to 10000]
    spacing: float | None = _field(None, 'm', 0.1, 10000)
    #: Whether the waves focus sunlight on the bottom.
    caustics: bool = _field(True)
    #: What the land is; absent: as the bottom, SAND where that is BLACK.
    #: One of BLACK, SAND, MUD, ROCK, CORAL.
    land: str | None = _field(None,
        words="BLACK SAND MUD ROCK CORAL")
    #: Whether waves feel the bottom of the file: they bend to the shore, grow
    #: and break.
    waves: bool = _field(True)


@dataclass(frozen=True)
class Preset(Record):
    """A change of the state under a name, to be made again: a sea, a water, a
    time of day. At most 32 are kept, with the state."""
    #: 1 to 64 of A-Z a-z 0-9 _ -.
    name: str | None = _field(None)
    #: For people.
    title: str | None = _field(None)
    #: The change: a merge patch of State in JSON, as PATCH /v1/state takes it,
    #: of at most 4096 bytes; tested when it is saved and, by what there is
    #: then, when it is made. [JSON; at most 4096 bytes]
    patch: str | None = _field(None, 'JSON')


@dataclass(frozen=True)
class ExerciseDone(Record):
    """What an event of the exercise has done so far."""
    #: Name of the event.
    event: str | None = _field(None)
    #: How often it took effect. [1; 0 to 4294967295]
    count: int = _field(0, '1', 0, 4294967295)
    #: Exercise time at which it last did. [s; 0 to 1000000000]
    time: float = _field(0.0, 's', 0, 1000000000)
    #: Whether its condition held at the last look, of one that acts at each
    #: entering.
    inside: bool = _field(False)


@dataclass(frozen=True)
class ExerciseRun(Record):
    """The exercise that the scene is in (pelagosd --exercises), written by the
    server: it is a part of the state, so that a replay, a restart and a rewind
    have it. A patch by anybody else takes the exercise from the server."""
    #: Its name.
    name: str | None = _field(None)
    #: One of IDLE, READY, RUNNING, PAUSED, ENDED.
    phase: str = _field('IDLE',
        words="IDLE READY RUNNING PAUSED ENDED")
    #: Exercise time when it last stopped running. [s; 0 to 1000000000]
    time: float = _field(0.0, 's', 0, 1000000000)
    #: Simulated time less exercise time, while it runs. [s; -1000000000 to
    #: 1000000000]
    offset: float = _field(0.0, 's', -1000000000, 1000000000)
    #: Simulated time when its phase last changed. [s; 0 to 1000000000]
    since: float = _field(0.0, 's', 0, 1000000000)
    #: clock.rate with which it goes on. [1; 0 to 100]
    rate: float = _field(1.0, '1', 0, 100)
    #: Exercise time of the last mark, at which the steps of own ship's model
    #: begin anew, so that a rewind has the same motion. [s; 0 to 1000000000]
    mark: float = _field(0.0, 's', 0, 1000000000)
    #: What it was made of: another text has another digest.
    digest: str | None = _field(None)
    #: Of the events that have done something.
    events: tuple[ExerciseDone, ...] = ()


@dataclass(frozen=True)
class State(Record):
    """The whole world. Lists are keyed: entities by id, views and presets by
    name."""
    clock: Clock | None = _field(None)
    origin: Origin | None = _field(None)
    sea: Sea | None = _field(None)
    water: Water | None = _field(None)
    sky: Sky | None = _field(None)
    entities: tuple[Entity, ...] = ()
    views: tuple[View, ...] = ()
    #: Counts accepted edits; read only, ignored in a patch. [1]
    revision: int | None = _field(None, '1')
    ownShip: OwnShip | None = _field(None)
    sources: Sources | None = _field(None)
    seabed: Seabed | None = _field(None)
    #: Changes under a name, at most 32.
    presets: tuple[Preset, ...] = ()
    exercise: ExerciseRun | None = _field(None)


@dataclass(frozen=True)
class SeaMoments(Record):
    """Integrals over waves. Slope variances are along and across the wind."""
    #: Significant wave height, 4 standard deviations. [m]
    significantHeight: float | None = _field(None, 'm')
    #: Slope variance along the wind. [1]
    slopeAlong: float | None = _field(None, '1')
    #: Slope variance across the wind. [1]
    slopeCross: float | None = _field(None, '1')
    #: Covariance of the two. [1]
    slopeMixed: float | None = _field(None, '1')


@dataclass(frozen=True)
class SpectrumRow(Record):
    """The spectrum at one frequency."""
    #: Angular frequency. [rad/s]
    omega: float | None = _field(None, 'rad/s')
    #: S(ω) over all directions. [m2 s/rad]
    density: float | None = _field(None, 'm2 s/rad')
    #: Mean direction the waves come from. [deg]
    direction: float | None = _field(None, 'deg')
    #: Circular standard deviation of direction, √(2 − 2 r1). [deg]
    spread: float | None = _field(None, 'deg')
    #: S(ω, θ) of waves that come from 0, 360/n, 2·360/n… deg. [m2 s/rad2]
    directional: tuple[float, ...] = ()


@dataclass(frozen=True)
class SpectrumFile(Record):
    """A file of a spectrum."""
    name: str | None = _field(None)
    #: MIME type; of several files together.
    type: str | None = _field(None)
    content: int | None = _field(None)


@dataclass(frozen=True)
class Spectrum(Record):
    """Spectrum."""
    #: Of the spectrum itself, by integration.
    spectrum: SeaMoments | None = _field(None)
    #: Of the waves that are drawn, with the slopes that only shading shows.
    drawn: SeaMoments | None = _field(None)
    #: Peak period: of the greatest S(ω); single waves are not in S. [s]
    peakPeriod: float | None = _field(None, 's')
    #: Mean direction the waves come from, weighted by energy. [deg]
    meanDirection: float | None = _field(None, 'deg')
    #: SpectrumQuery.wavelength, where it was given; below it: of the shorter
    #: waves. [m]
    wavelength: float | None = _field(None, 'm')
    spectrumBelow: SeaMoments | None = _field(None)
    drawnBelow: SeaMoments | None = _field(None)
    rows: tuple[SpectrumRow, ...] = ()
    #: Share of the sea under whitecaps, as photographs count them. [1]
    whitecaps: float | None = _field(None, '1')
    #: Significant height of what is neither swell nor single waves nor ring
    #: waves of rain. [m]
    windSeaHeight: float | None = _field(None, 'm')
    #: Significant height of all trains of swell together. [m]
    swellHeight: float | None = _field(None, 'm')
    #: Beaufort number of the wind, by WMO's classes of speed. [1]
    beaufort: int | None = _field(None, '1')
    #: Degree of Douglas's scale of the significant height. [1]
    douglas: int | None = _field(None, '1')
    #: Wave age c/U: phase speed of the wind sea's peak over the wind at 10 m.
    #: Below 1.2 the wind drives the waves, above they outrun it; absent
    #: without wind and of a buoy's record. [1]
    waveAge: float | None = _field(None, '1')
    #: Where SpectrumQuery.format asks for some.
    files: tuple[SpectrumFile, ...] = ()


@dataclass(frozen=True)
class Brdf(Record):
    """Terms of Ross's BRDF (Bruneton 2010, eq. 5 to 15, 24, 26)."""
    #: Slope variance along the wind that it is for. [1]
    slopeAlong: float | None = _field(None, '1')
    #: The same across the wind. [1]
    slopeCross: float | None = _field(None, '1')
    #: From the vertical to the facets that mirror the Sun to the eye. [deg]
    halfZenith: float | None = _field(None, 'deg')
    #: Density of their slopes, p. [1]
    slopeDensity: float | None = _field(None, '1')
    #: Smith's lambda of the eye. [1]
    lambdaView: float | None = _field(None, '1')
    #: The same of the Sun. [1]
    lambdaSun: float | None = _field(None, '1')
    #: 1 / (1 + lambda_view + lambda_sun). [1]
    shadowing: float | None = _field(None, '1')
    #: Reflectance of those facets at 550 nm, by Fresnel's equations. [1]
    fresnel: float | None = _field(None, '1')
    #: Effective reflectance by Smith's masking, eq. 24 with Fresnel's
    #: equations. [1]
    meanFresnel: float | None = _field(None, '1')
    #: The same over the facets that are seen, as it is drawn. [1]
    seenFresnel: float | None = _field(None, '1')
    #: The BRDF as it is drawn: eq. 13 with the facets that are seen and the
    #: Sun's disc. [1/sr]
    brdf: float | None = _field(None, '1/sr')
    #: It times the cosine of the Sun's zenith angle: radiance for an
    #: irradiance of 1 normal to the Sun's beam. [1/sr]
    reflectedSun: float | None = _field(None, '1/sr')


@dataclass(frozen=True)
class SkyLight(Record):
    """Lists are at 680, 550, 440 nm."""
    #: Of the sky, by Sun, Moon and night, without discs and stars.
    #: [W/m2/sr/nm]
    radiance: tuple[float, ...] = ()
    #: The same to the eye. [cd/m2]
    luminance: float | None = _field(None, 'cd/m2')
    #: Transmittance of the air in this direction, to space; 0 into the sea.
    #: [1]
    transmittance: tuple[float, ...] = ()
    #: Transmittance towards the Sun, less what of its disc has set. [1]
    sunTransmittance: tuple[float, ...] = ()
    #: Of the Sun normal to its beam, at the eye. [W/m2/nm]
    sunIrradiance: tuple[float, ...] = ()
    #: The same of the Moon. [W/m2/nm]
    moonIrradiance: tuple[float, ...] = ()
    #: Of the night itself, in radiance too: airglow, zodiacal light, faint
    #: stars. [W/m2/sr/nm]
    nightRadiance: tuple[float, ...] = ()
    #: What the lists are at. [nm]
    wavelength: tuple[float, ...] = ()


@dataclass(frozen=True)
class WaterLight(Record):
    """Lists are at 680, 550, 440 nm, or at the wavelengths asked for."""
    #: Radiance of light scattered once. [1/sr]
    single: tuple[float, ...] = ()
    #: Scattered twice. [1/sr]
    second: tuple[float, ...] = ()
    #: Scattered more often, or mirrored by the surface from below. [1/sr]
    higher: tuple[float, ...] = ()
    #: Reflected by the bottom. [1/sr]
    bottom: tuple[float, ...] = ()
    #: All of it. [1/sr]
    total: tuple[float, ...] = ()
    #: Standard error of total, of MONTECARLO. [1/sr]
    totalError: tuple[float, ...] = ()
    #: Of the bottom, what was not scattered; not of GPU. [1/sr]
    bottomDirect: tuple[float, ...] = ()
    #: Absorption of the water it is for. [1/m]
    absorption: tuple[float, ...] = ()
    #: Its scattering. [1/m]
    scattering: tuple[float, ...] = ()
    #: Mean cosine of scattering. [1]
    asymmetry: tuple[float, ...] = ()
    #: Of the bottom. [1]
    albedo: tuple[float, ...] = ()
    #: Of the water. [m]
    depth: float | None = _field(None, 'm')
    #: One of ALL, TWO, PAPER, SINGLE.
    orders: str | None = _field(None,
        words="ALL TWO PAPER SINGLE")
    #: What the lists are at. [nm]
    wavelength: tuple[float, ...] = ()
    #: Absorption by what absorbs, first by sea water itself; its sum is
    #: absorption. Of waters that are known by sums only, all is in
    #: dissolved_absorption. [1/m]
    waterAbsorption: tuple[float, ...] = ()
    #: By phytoplankton. [1/m]
    phytoplanktonAbsorption: tuple[float, ...] = ()
    #: By dissolved matter. [1/m]
    dissolvedAbsorption: tuple[float, ...] = ()
    #: By other particles. [1/m]
    detritusAbsorption: tuple[float, ...] = ()
    #: Scattering by the water itself. [1/m]
    molecularScattering: tuple[float, ...] = ()
    #: By particles. [1/m]
    particleScattering: tuple[float, ...] = ()
    #: By more than 90 degrees, by both. [1/m]
    backscattering: tuple[float, ...] = ()
    #: Of REFERENCE: total over the irradiance above the surface, Rrs. [1/sr]
    remoteSensingReflectance: tuple[float, ...] = ()
    #: Of REFERENCE: irradiance up over down just below the surface, R(0-). [1]
    irradianceReflectance: tuple[float, ...] = ()
    #: Of REFERENCE: attenuation of downward irradiance Kd, from the surface to
    #: 1/Kd. [1/m]
    diffuseAttenuation: tuple[float, ...] = ()
    #: Of REFERENCE: what came of light of a shorter wave by Raman scattering,
    #: in total too; of GPU it is in higher, of MONTECARLO nowhere. [1/sr]
    raman: tuple[float, ...] = ()


@dataclass(frozen=True)
class Optics(Record):
    """Optics."""
    #: Whose answer.
    #: One of REFERENCE, GPU, MONTECARLO.
    from_: str | None = _field(None,
        words="REFERENCE GPU MONTECARLO")
    #: The device that drew it, of GPU.
    device: str | None = _field(None)
    #: The Sun it is for. [deg]
    sunElevation: float | None = _field(None, 'deg')
    #: Its compass direction. [deg]
    sunAzimuth: float | None = _field(None, 'deg')
    brdf: Brdf | None = _field(None)
    sky: SkyLight | None = _field(None)
    water: WaterLight | None = _field(None)
    #: The Moon, where there is one. [deg]
    moonElevation: float | None = _field(None, 'deg')
    #: Its compass direction. [deg]
    moonAzimuth: float | None = _field(None, 'deg')
    #: Share of its disc that is lit. [1]
    moonPhase: float | None = _field(None, '1')


@dataclass(frozen=True)
class Error(Record):
    """Error."""
    #: One of MALFORMED, NOT_FOUND, OUT_OF_RANGE, INVALID, CONFLICT, BUSY,
    #: INTERNAL, UNAUTHORIZED, FORBIDDEN, IO.
    code: str | None = _field(None,
        words="MALFORMED NOT_FOUND OUT_OF_RANGE INVALID CONFLICT BUSY "
        "INTERNAL UNAUTHORIZED FORBIDDEN IO")
    #: Path of the field at fault, if one is.
    path: str | None = _field(None)
    #: The offending value as text.
    value: str | None = _field(None)
    #: Unit of the field.
    unit: str | None = _field(None)
    #: Legal range of the field.
    minimum: float | None = _field(None)
    maximum: float | None = _field(None)
    #: A sentence for people.
    message: str | None = _field(None)


@dataclass(frozen=True)
class ModelPoint(Record):
    """A place on a model, from amidships in the waterline."""
    #: Name, for people.
    name: str | None = _field(None)
    #: Towards the bow. [m; -1000 to 1000]
    forward: float = _field(0.0, 'm', -1000, 1000)
    #: To starboard. [m; -1000 to 1000]
    right: float = _field(0.0, 'm', -1000, 1000)
    #: Above the waterline. [m; -1000 to 1000]
    up: float = _field(0.0, 'm', -1000, 1000)


@dataclass(frozen=True)
class ModelLight(Record):
    """A light of a model. It is listed, not drawn."""
    #: Name, for people.
    name: str | None = _field(None)
    #: Towards the bow. [m; -1000 to 1000]
    forward: float = _field(0.0, 'm', -1000, 1000)
    #: To starboard. [m; -1000 to 1000]
    right: float = _field(0.0, 'm', -1000, 1000)
    #: Above the waterline. [m; -1000 to 1000]
    up: float = _field(0.0, 'm', -1000, 1000)
    #: sRGB, 65536 red + 256 green + blue. [1; 0 to 16777215]
    colour: int = _field(16777215, '1', 0, 16777215)
    #: Nominal range. [nmi; 0 to 50]
    range: float = _field(3.0, 'nmi', 0, 50)
    #: The arc through which it shines, clockwise from the bow, from here.
    #: [deg; -360 to 360]
    from_: float = _field(0.0, 'deg', -360, 360)
    #: To here; the same: all round. [deg; -360 to 360]
    to: float = _field(0.0, 'deg', -360, 360)


@dataclass(frozen=True)
class ModelInfo(Record):
    """One model."""
    name: str | None = _field(None)
    #: One of OTHER, CONTAINER_SHIP, TANKER, BULK_CARRIER, CARGO_SHIP, FERRY,
    #: CRUISE_SHIP, TUG, FISHING_BOAT, SAILING_YACHT, MOTOR_YACHT,
    #: PILOT_LAUNCH, PATROL_BOAT, WARSHIP, WORK_SHIP, RIB, USV, ROWING_BOAT,
    #: LATERAL_PORT, LATERAL_STARBOARD, CARDINAL_NORTH, CARDINAL_EAST,
    #: CARDINAL_SOUTH, CARDINAL_WEST, SAFE_WATER, SPECIAL_MARK,
    #: ISOLATED_DANGER, BEACON, LIGHT_FLOAT, LIFE_RAFT, LIFEBOAT, PERSON.
    class_: str | None = _field(None,
        words="OTHER CONTAINER_SHIP TANKER BULK_CARRIER CARGO_SHIP FERRY "
        "CRUISE_SHIP TUG FISHING_BOAT SAILING_YACHT MOTOR_YACHT "
        "PILOT_LAUNCH PATROL_BOAT WARSHIP WORK_SHIP RIB USV ROWING_BOAT "
        "LATERAL_PORT LATERAL_STARBOARD CARDINAL_NORTH CARDINAL_EAST "
        "CARDINAL_SOUTH CARDINAL_WEST SAFE_WATER SPECIAL_MARK "
        "ISOLATED_DANGER BEACON LIGHT_FLOAT LIFE_RAFT LIFEBOAT PERSON")
    #: Size over all, and of the highest point above the waterline. [m]
    length: float | None = _field(None, 'm')
    #:  [m]
    beam: float | None = _field(None, 'm')
    #:  [m]
    draught: float | None = _field(None, 'm')
    #:  [m]
    height: float | None = _field(None, 'm')
    #: Triangles of each level of detail, the finest first. [1]
    triangles: tuple[int, ...] = ()
    #: Memory that it takes while an entity has it. [B]
    bytes: int | None = _field(None, 'B')
    #: It is built in.
    builtin: bool | None = _field(None)
    #: For people: what a built-in model is; what of a file was left out.
    text: str | None = _field(None)
    #: Why the file cannot be used; then there are no sizes.
    error: Error | None = _field(None)
    eyes: tuple[ModelPoint, ...] = ()
    lights: tuple[ModelLight, ...] = ()


@dataclass(frozen=True)
class Models(Record):
    """Models."""
    models: tuple[ModelInfo, ...] = ()


@dataclass(frozen=True)
class PixelBox(Record):
    """A box in a picture, in pixels from its upper left corner. Of what is
    visible it is whole pixels: columns x to x + width - 1."""
    #:  [px]
    x: float | None = _field(None, 'px')
    #:  [px]
    y: float | None = _field(None, 'px')
    #:  [px]
    width: float | None = _field(None, 'px')
    #:  [px]
    height: float | None = _field(None, 'px')


@dataclass(frozen=True)
class SeenPoint(Record):
    """A point of an entity."""
    #: East of the origin, as surface queries have it. [m]
    east: float | None = _field(None, 'm')
    #: North of the origin. [m]
    north: float | None = _field(None, 'm')
    #: Above altitude 0. [m]
    up: float | None = _field(None, 'm')
    #: From the eye to the right in the view's axes, with the Earth's curve.
    #: [m]
    right: float | None = _field(None, 'm')
    #: From the eye down. [m]
    down: float | None = _field(None, 'm')
    #: From the eye ahead. [m]
    ahead: float | None = _field(None, 'm')
    #: Where the picture shows it; absent: it is behind the eye. [px]
    x: float | None = _field(None, 'px')
    #:  [px]
    y: float | None = _field(None, 'px')


@dataclass(frozen=True)
class SeenEntity(Record):
    """What a picture shows of an entity that has a model."""
    #: Its number.
    id: int | None = _field(None)
    #: Name of its model.
    model: str | None = _field(None)
    #: One of OTHER, CONTAINER_SHIP, TANKER, BULK_CARRIER, CARGO_SHIP, FERRY,
    #: CRUISE_SHIP, TUG, FISHING_BOAT, SAILING_YACHT, MOTOR_YACHT,
    #: PILOT_LAUNCH, PATROL_BOAT, WARSHIP, WORK_SHIP, RIB, USV, ROWING_BOAT,
    #: LATERAL_PORT, LATERAL_STARBOARD, CARDINAL_NORTH, CARDINAL_EAST,
    #: CARDINAL_SOUTH, CARDINAL_WEST, SAFE_WATER, SPECIAL_MARK,
    #: ISOLATED_DANGER, BEACON, LIGHT_FLOAT, LIFE_RAFT, LIFEBOAT, PERSON.
    class_: str | None = _field(None,
        words="OTHER CONTAINER_SHIP TANKER BULK_CARRIER CARGO_SHIP FERRY "
        "CRUISE_SHIP TUG FISHING_BOAT SAILING_YACHT MOTOR_YACHT "
        "PILOT_LAUNCH PATROL_BOAT WARSHIP WORK_SHIP RIB USV ROWING_BOAT "
        "LATERAL_PORT LATERAL_STARBOARD CARDINAL_NORTH CARDINAL_EAST "
        "CARDINAL_SOUTH CARDINAL_WEST SAFE_WATER SPECIAL_MARK "
        "ISOLATED_DANGER BEACON LIGHT_FLOAT LIFE_RAFT LIFEBOAT PERSON")
    #: Of the pixels that show it, by the layer id; absent: none does.
    visible: PixelBox | None = _field(None)
    #: Of its shape above its own waterline, whatever hides it; it may reach
    #: beyond the picture.
    whole: PixelBox | None = _field(None)
    #: Pixels that show it. [1]
    pixels: int | None = _field(None, '1')
    #: Pixels of the picture in its whole shape. [1]
    wholePixels: int | None = _field(None, '1')
    #: Share of these that do not show it: hidden by other entities, waves,
    #: land or the horizon. [1; 0 to 1]
    hidden: float | None = _field(None, '1', 0, 1)
    #: The whole shape reaches beyond the picture.
    truncated: bool | None = _field(None)
    #: Corners of the model's box: stern starboard keel, bow starboard keel,
    #: stern port keel, bow port keel, and these four at its top.
    corners: tuple[SeenPoint, ...] = ()
    #: Ends of its waterline on the centreline: the bow's, the stern's.
    waterline: tuple[SeenPoint, ...] = ()
    #: From the eye to its origin, amidships in the waterline. [m]
    distance: float | None = _field(None, 'm')
    #: The same, true. [deg; 0 to 360]
    bearing: float | None = _field(None, 'deg', 0, 360)
    #: The pose that is drawn. [deg]
    latitude: float | None = _field(None, 'deg')
    #:  [deg]
    longitude: float | None = _field(None, 'deg')
    #:  [m]
    altitude: float | None = _field(None, 'm')
    #:  [deg]
    heading: float | None = _field(None, 'deg')
    #:  [deg]
    pitch: float | None = _field(None, 'deg')
    #:  [deg]
    roll: float | None = _field(None, 'deg')
    #:  [m/s]
    speed: float | None = _field(None, 'm/s')
    #:  [deg]
    course: float | None = _field(None, 'deg')
    #: Of its model, over all. [m]
    length: float | None = _field(None, 'm')
    #:  [m]
    beam: float | None = _field(None, 'm')
    #:  [m]
    draught: float | None = _field(None, 'm')


@dataclass(frozen=True)
class FrameTruth(Record):
    """Ground truth of a picture, as `data` of a Frame of format JSON. It is a
    function of what the picture shows; a FramesRequest that has the view in
    two formats has the picture and the truth of one moment."""
    #: Name of the view.
    view: str | None = _field(None)
    #: Simulated time. [s]
    time: float | None = _field(None, 's')
    #: Revision of the state.
    revision: int | None = _field(None)
    #: Of the picture. [px]
    width: int | None = _field(None, 'px')
    #:  [px]
    height: int | None = _field(None, 'px')
    #: Entities with a pixel, or that would have one if nothing hid them.
    entities: tuple[SeenEntity, ...] = ()
