/* CIGI's weather, waves and water on the scene. */
#include "bridges/cigi_testkit.h"

static void waves_are_of_the_sea(void **state)
{
    (void)state;
    begin();
    with(PEL_CIGI_KIND_WAVE, PEL_CIGI_WAVE_ID, 1.0, PEL_CIGI_WAVE_ENABLE, 1.0,
         PEL_CIGI_WAVE_HEIGHT, 2.0, PEL_CIGI_WAVE_PERIOD, 9.0,
         PEL_CIGI_WAVE_DIRECTION, 90.0, PEL_CIGI_WAVE_PHASE, -90.0, 0);
    train(9, 1, 1);
    send();
    const Pelagos__Sea *sea = pel_scene_state(scene)->sea;
    assert_int_equal(sea->n_wave, 2);
    assert_near(sea->wave[0]->height, 2, 0);
    assert_near(sea->wave[0]->period, 9, 0);
    assert_near(sea->wave[0]->direction, 270, 0);
    assert_near(sea->wave[0]->phase, 270, 0);
    begin();
    train(1, 2, 0);
    send();
    sea = pel_scene_state(scene)->sea;
    assert_int_equal(sea->n_wave, 1);
    assert_near(sea->wave[0]->height, 1, 0);
    begin();
    train(9, 2, 0);
    send();
    assert_int_equal(pel_scene_state(scene)->sea->n_wave, 0);
    begin();
    for (int i = 0; i < 9; i++) {
        train(i, 1, 1);
    }
    send();
    assert_int_equal(pel_scene_state(scene)->sea->n_wave, 8);
    assert_int_equal(pel_cigi_counters(cigi)->skipped_packets, 1);
}

/* One wave on a calm sea: its crest, and the tide below it, where HOT asks. */
static void a_crest_stands_where_it_was_ordered(void **state)
{
    (void)state;
    begin();
    /* Trochoids draw single waves exactly, cascades the nearest they have. */
    with(PEL_CIGI_KIND_SHORT_COMPONENT, PEL_CIGI_SHORT_COMPONENT_ID, 5.0,
         PEL_CIGI_SHORT_COMPONENT_CLASS, 7.0, PEL_CIGI_SHORT_COMPONENT_STATE,
         0.0, 0);
    with(PEL_CIGI_KIND_ATMOSPHERE, PEL_CIGI_ATMOSPHERE_ENABLE, 1.0,
         PEL_CIGI_ATMOSPHERE_VISIBILITY, 20000.0, 0);
    train(1, 2, 1);
    with(PEL_CIGI_KIND_MARITIME, PEL_CIGI_MARITIME_ENABLE, 1.0,
         PEL_CIGI_MARITIME_HEIGHT, 3.5, PEL_CIGI_MARITIME_CLARITY, 50.0, 0);
    send();
    assert_near(pel_scene_state(scene)->sea->level, 3.5, 0);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    struct pel_vec2 origin = { 0, 0 };
    struct pel_surface_sample crest;
    pel_snapshot_surface(s, &origin, 1, 0, false, &crest);
    pel_snapshot_unref(s);
    assert_near(crest.height_m, 4.5, 1e-9);
    begin();
    with(PEL_CIGI_KIND_MARITIME, PEL_CIGI_MARITIME_ENABLE, 1.0,
         PEL_CIGI_MARITIME_HEIGHT, 20.5, 0);
    send();
    assert_int_equal(pel_cigi_counters(cigi)->refused_edits, 1);
    assert_near(pel_scene_state(scene)->sea->level, 3.5, 0);
}

/* A wavelength alone: deep-water dispersion. */
static void a_wavelength_gives_the_period(void **state)
{
    (void)state;
    begin();
    with(PEL_CIGI_KIND_WAVE, PEL_CIGI_WAVE_ENABLE, 1.0, PEL_CIGI_WAVE_HEIGHT,
         1.0, PEL_CIGI_WAVE_LENGTH, 156.13, 0);
    send();
    assert_near(pel_scene_state(scene)->sea->wave[0]->period, 10, 1e-3);
}

static void weather_is_of_the_region_the_view_is_in(void **state)
{
    (void)state;
    begin();
    wind(5, 100, 20000);
    with(PEL_CIGI_KIND_REGION, PEL_CIGI_REGION_ID, 3.0, PEL_CIGI_REGION_STATE,
         1.0, PEL_CIGI_REGION_LATITUDE, 52.6, PEL_CIGI_REGION_LONGITUDE, 5.2,
         PEL_CIGI_REGION_X, 2000.0, PEL_CIGI_REGION_Y, 2000.0, 0);
    with(PEL_CIGI_KIND_WEATHER, PEL_CIGI_WEATHER_REGION, 3.0,
         PEL_CIGI_WEATHER_SCOPE, 1.0, PEL_CIGI_WEATHER_ENABLE, 1.0,
         PEL_CIGI_WEATHER_VISIBILITY, 900.0, PEL_CIGI_WEATHER_WIND, 12.0,
         PEL_CIGI_WEATHER_WIND_DIRECTION, 200.0, 0);
    send();
    const Pelagos__State *s = pel_scene_state(scene);
    assert_near(s->sea->wind_speed, 12, 0);
    assert_near(s->sea->wind_direction, 200, 0);
    assert_near(s->sky->visibility, 900, 0);
    for (double on = 0; on <= 1; on++) { /* a region that is off is none */
        begin();
        with(PEL_CIGI_KIND_REGION, PEL_CIGI_REGION_ID, 3.0,
             PEL_CIGI_REGION_STATE, on, PEL_CIGI_REGION_LATITUDE, 52.6,
             PEL_CIGI_REGION_LONGITUDE, 5.2, PEL_CIGI_REGION_X, 2000.0,
             PEL_CIGI_REGION_Y, 2000.0, 0);
        send();
        s = pel_scene_state(scene);
        assert_near(s->sea->wind_speed, on > 0 ? 12 : 5, 0);
        assert_near(s->sky->visibility, on > 0 ? 900 : 20000, 0);
    }
    begin();
    place_ship(1, 52.62, 0); /* 2.2 km north */
    send();
    begin(); /* the view is where the ship is since the frame before */
    send();
    s = pel_scene_state(scene);
    assert_near(s->sea->wind_speed, 5, 0);
    assert_near(s->sky->visibility, 20000, 0);
}

static void layer(double id, double scope, double on, double type, double cover,
                  double base, double thickness, double visibility)
{
    with(PEL_CIGI_KIND_WEATHER, PEL_CIGI_WEATHER_REGION, 3.0,
         PEL_CIGI_WEATHER_LAYER, id, PEL_CIGI_WEATHER_SCOPE, scope,
         PEL_CIGI_WEATHER_ENABLE, on, PEL_CIGI_WEATHER_CLOUD, type,
         PEL_CIGI_WEATHER_COVERAGE, cover, PEL_CIGI_WEATHER_BASE, base,
         PEL_CIGI_WEATHER_THICKNESS, thickness, PEL_CIGI_WEATHER_BAND, 15.0,
         PEL_CIGI_WEATHER_VISIBILITY, visibility, PEL_CIGI_WEATHER_WIND, 6.0,
         0);
}

static void storm(double layer_, double on, double lightning, double severity)
{
    begin();
    with(PEL_CIGI_KIND_WEATHER, PEL_CIGI_WEATHER_LAYER, layer_,
         PEL_CIGI_WEATHER_ENABLE, on, PEL_CIGI_WEATHER_LIGHTNING, lightning,
         PEL_CIGI_WEATHER_SEVERITY, severity, PEL_CIGI_WEATHER_BASE, 900.0, 0);
    send();
}

/* The layer that began it ends it, and a reset. */
static void lightning_is_a_layers(void **state)
{
    (void)state;
    storm(2, 1, 1, 3);
    assert_near(pel_scene_state(scene)->sky->lightning, 8, 0);
    storm(1, 1, 0, 0);
    assert_near(pel_scene_state(scene)->sky->lightning, 8, 0);
    storm(2, 1, 0, 3);
    assert_near(pel_scene_state(scene)->sky->lightning, 0, 0);
    storm(1, 1, 1, 0);
    assert_near(pel_scene_state(scene)->sky->lightning, 2, 0);
    storm(1, 0, 1, 0);
    assert_near(pel_scene_state(scene)->sky->lightning, 0, 0);
}

/* Ground fog with a thickness is a layer, in a region a bank in its place; of
 * clouds the layer that covers most. */
static void layers_are_fog_and_clouds(void **state)
{
    (void)state;
    begin();
    wind(5, 100, 20000);
    with(PEL_CIGI_KIND_REGION, PEL_CIGI_REGION_ID, 3.0, PEL_CIGI_REGION_STATE,
         1.0, PEL_CIGI_REGION_LATITUDE, 52.7, PEL_CIGI_REGION_LONGITUDE, 5.3,
         PEL_CIGI_REGION_X, 2000.0, PEL_CIGI_REGION_Y, 1000.0, 0);
    layer(0, 0, 1, 0, 0, 0, 60, 300);
    layer(0, 1, 1, 0, 0, 0, 40, 100);
    layer(1, 0, 1, 7, 30, 800, 400, 9000);
    layer(2, 0, 1, 1, 70, 2800, 0, 9000);
    send();
    const Pelagos__Sky *sky = pel_scene_state(scene)->sky;
    assert_int_equal(sky->n_fog, 2);
    assert_near(sky->fog[0]->visibility, 300, 0);
    assert_near(sky->fog[0]->top, 60, 0);
    assert_near(sky->fog[0]->edge, 15, 0);
    assert_true(!sky->fog[0]->has_radius);
    assert_near(sky->fog[1]->latitude, 52.7, 1e-9);
    assert_near(sky->fog[1]->radius, sqrt(2e6 / M_PI), 1e-6);
    assert_near(sky->visibility, 20000, 0);
    assert_near(pel_scene_state(scene)->sea->wind_speed, 6, 0);
    assert_near(sky->cloud_cover, 5.6, 1e-9);
    assert_int_equal(sky->cloud_genus, PELAGOS__CLOUD_GENUS__ALTOCUMULUS);
    assert_near(sky->cloud_base, 2800, 0);
    begin();
    layer(0, 0, 0, 0, 0, 0, 60, 300);
    layer(2, 0, 0, 1, 70, 2800, 0, 9000);
    send();
    sky = pel_scene_state(scene)->sky;
    assert_int_equal(sky->n_fog, 1);
    assert_true(sky->fog[0]->has_radius);
    assert_near(sky->cloud_cover, 2.4, 1e-9);
    assert_near(sky->cloud_thickness, 400, 0);
    begin();
    layer(0, 1, 0, 0, 0, 0, 60, 300);
    layer(1, 0, 0, 7, 30, 800, 400, 9000);
    send();
    sky = pel_scene_state(scene)->sky;
    assert_true(sky->n_fog == 0 && sky->cloud_cover == 0);
}

/* From outside a region's wind is seen in its short waves. */
static void a_region_is_an_area(void **state)
{
    (void)state;
    begin();
    wind(4, 100, 20000);
    place_ship(1, 52.7, 0); /* 11 km north */
    send();
    begin();
    send();
    begin();
    with(PEL_CIGI_KIND_REGION, PEL_CIGI_REGION_ID, 3.0, PEL_CIGI_REGION_STATE,
         1.0, PEL_CIGI_REGION_LATITUDE, 52.6, PEL_CIGI_REGION_LONGITUDE, 5.2,
         PEL_CIGI_REGION_X, 2000.0, PEL_CIGI_REGION_Y, 1000.0,
         PEL_CIGI_REGION_TRANSITION, 200.0, 0);
    with(PEL_CIGI_KIND_WEATHER, PEL_CIGI_WEATHER_REGION, 3.0,
         PEL_CIGI_WEATHER_SCOPE, 1.0, PEL_CIGI_WEATHER_ENABLE, 1.0,
         PEL_CIGI_WEATHER_VISIBILITY, 20000.0, PEL_CIGI_WEATHER_WIND, 9.0, 0);
    send();
    const Pelagos__Sea *sea = pel_scene_state(scene)->sea;
    assert_near(sea->wind_speed, 4, 0);
    assert_int_equal(sea->n_areas, 1);
    assert_near(sea->areas[0]->factor, 1.5, 0); /* √(9/4) */
    assert_near(sea->areas[0]->edge, 200, 0);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    const struct pel_sea_desc *d = &pel_snapshot_sea(s)->desc;
    assert_int_equal(d->area_count, 1);
    /* Its long side north, out to the middle of the transition. */
    double north = 0, east = 0;
    for (int i = 0; i < d->area[0].corner_count; i++) {
        north = fmax(north, fabs(d->area[0].corner[i].y));
        east = fmax(east, fabs(d->area[0].corner[i].x));
    }
    assert_near(north, 1100, 0);
    assert_near(east, 600, 0);
    pel_snapshot_unref(s);
    begin();
    with(PEL_CIGI_KIND_REGION, PEL_CIGI_REGION_ID, 3.0, PEL_CIGI_REGION_STATE,
         2.0, 0);
    send();
    assert_int_equal(pel_scene_state(scene)->sea->n_areas, 0);
}

/* A region of 2 km with 1 km around it in which its weather comes. */
static void weather_goes_over_across_the_transition(void **state)
{
    (void)state;
    /* Latitudes 1000, 1250, 1500 and 2100 m north of the centre. */
    const double north_m[] = { 999, 1250, 1500, 2001 };
    const double share[] = { 1, 0.75, 0.5, 0 };
    double last_mps = 12;
    begin();
    wind(4, 200, 20000);
    with(PEL_CIGI_KIND_REGION, PEL_CIGI_REGION_ID, 3.0, PEL_CIGI_REGION_STATE,
         1.0, PEL_CIGI_REGION_LATITUDE, 52.6, PEL_CIGI_REGION_LONGITUDE, 5.2,
         PEL_CIGI_REGION_X, 2000.0, PEL_CIGI_REGION_Y, 2000.0,
         PEL_CIGI_REGION_TRANSITION, 1000.0, 0);
    with(PEL_CIGI_KIND_WEATHER, PEL_CIGI_WEATHER_REGION, 3.0,
         PEL_CIGI_WEATHER_SCOPE, 1.0, PEL_CIGI_WEATHER_ENABLE, 1.0,
         PEL_CIGI_WEATHER_VISIBILITY, 500.0, PEL_CIGI_WEATHER_WIND, 12.0,
         PEL_CIGI_WEATHER_WIND_DIRECTION, 200.0, 0);
    with(PEL_CIGI_KIND_MARITIME, PEL_CIGI_MARITIME_ENABLE, 1.0,
         PEL_CIGI_MARITIME_CLARITY, 50.0, 0);
    with(PEL_CIGI_KIND_MARITIME, PEL_CIGI_MARITIME_REGION, 3.0,
         PEL_CIGI_MARITIME_SCOPE, 1.0, PEL_CIGI_MARITIME_ENABLE, 1.0,
         PEL_CIGI_MARITIME_HEIGHT, 4.0, PEL_CIGI_MARITIME_CLARITY, 50.0, 0);
    send();
    for (size_t i = 0; i < sizeof share / sizeof *share; i++) {
        begin();
        /* 111,278 m a degree there; the view follows a frame later. */
        place_ship(1, 52.6 + north_m[i] / 111278, 0);
        send();
        begin();
        send();
        const Pelagos__State *s = pel_scene_state(scene);
        assert_near(s->sea->level, 4 * share[i], 0.01);
        assert_near(log(s->sky->visibility),
                    log(20000) + share[i] * log(500.0 / 20000), 0.01);
        /* To half a step. */
        assert_near(s->sea->wind_speed, 4 + 8 * share[i], 0.25);
        assert_near(s->sea->wind_direction, 200, 2.5);
        assert_true(s->sea->wind_speed <= last_mps);
        last_mps = s->sea->wind_speed;
    }
    assert_near(last_mps, 4, 0);
    /* Back in the middle; a region's conditions have a switch, which the
     * whole sea's have not. */
    begin();
    place_ship(1, 52.6, 0);
    send();
    begin();
    with(PEL_CIGI_KIND_MARITIME, PEL_CIGI_MARITIME_HEIGHT, 1.0,
         PEL_CIGI_MARITIME_CLARITY, 50.0, 0);
    send();
    assert_near(pel_scene_state(scene)->sea->level, 4, 0.01);
    begin();
    with(PEL_CIGI_KIND_MARITIME, PEL_CIGI_MARITIME_REGION, 3.0,
         PEL_CIGI_MARITIME_SCOPE, 1.0, PEL_CIGI_MARITIME_HEIGHT, 4.0,
         PEL_CIGI_MARITIME_CLARITY, 50.0, 0);
    send();
    assert_near(pel_scene_state(scene)->sea->level, 1, 0.01);
}

static void components_give_whole_sea_states(void **state)
{
    (void)state;
    float mps = 14, from = 225, fetch = 90000;
    uint32_t words[3];
    memcpy(&words[0], &mps, 4);
    memcpy(&words[1], &from, 4);
    memcpy(&words[2], &fetch, 4);
    begin();
    with(PEL_CIGI_KIND_COMPONENT, PEL_CIGI_COMPONENT_ID, 1.0,
         PEL_CIGI_COMPONENT_CLASS, 7.0, PEL_CIGI_COMPONENT_STATE, 1.0,
         PEL_CIGI_COMPONENT_DATA1, (double)words[0], PEL_CIGI_COMPONENT_DATA2,
         (double)words[1], PEL_CIGI_COMPONENT_DATA3, (double)words[2],
         PEL_CIGI_COMPONENT_DATA5, 77.0, 0);
    send();
    const Pelagos__Sea *sea = pel_scene_state(scene)->sea;
    assert_near(sea->wind_speed, 14, 0);
    assert_near(sea->wind_direction, 225, 0);
    assert_near(sea->fetch, 90000, 0);
    assert_int_equal(sea->spectrum, PELAGOS__SPECTRUM_KIND__JONSWAP);
    assert_int_equal(sea->seed, 77);
    /* Every spectrum of the schema but a buoy's record. */
    const ProtobufCEnumDescriptor *all = &pelagos__spectrum_kind__descriptor;
    for (int i = 0; i <= (int)all->n_values; i++) {
        int before = (int)pel_scene_state(scene)->sea->spectrum;
        bool taken =
            i < (int)all->n_values && i != PELAGOS__SPECTRUM_KIND__MEASURED;
        begin();
        with(PEL_CIGI_KIND_COMPONENT, PEL_CIGI_COMPONENT_ID, 1.0,
             PEL_CIGI_COMPONENT_CLASS, 7.0, PEL_CIGI_COMPONENT_STATE, (double)i,
             PEL_CIGI_COMPONENT_DATA1, (double)words[0], 0);
        send();
        assert_int_equal(pel_scene_state(scene)->sea->spectrum,
                         taken ? i : before);
    }
    begin();
    with(PEL_CIGI_KIND_SHORT_COMPONENT, PEL_CIGI_SHORT_COMPONENT_ID, 2.0,
         PEL_CIGI_SHORT_COMPONENT_CLASS, 7.0, PEL_CIGI_SHORT_COMPONENT_STATE,
         4.0, PEL_CIGI_SHORT_COMPONENT_DATA1, (double)words[1], 0);
    send();
    /* Beaufort 4: 0.836 · 8 m/s */
    assert_near(pel_scene_state(scene)->sea->wind_speed, 6.688, 1e-12);
    begin();
    with(PEL_CIGI_KIND_COMPONENT, PEL_CIGI_COMPONENT_ID, 1.0,
         PEL_CIGI_COMPONENT_CLASS, 7.0, PEL_CIGI_COMPONENT_DATA1,
         (double)0x7f800001u, 0);
    send(); /* NaN */
    assert_int_equal(pel_cigi_counters(cigi)->refused_edits, 1);
    assert_near(pel_scene_state(scene)->sea->wind_speed, 6.688, 1e-12);
}

/* With the ephemeris off the Sun stands where the date puts it. */
static void the_sun_stands_without_ephemeris(void **state)
{
    (void)state;
    double elevation[2];
    for (int i = 0; i < 2; i++) {
        begin();
        with(PEL_CIGI_KIND_CELESTIAL, PEL_CIGI_CELESTIAL_HOUR, 16.0,
             PEL_CIGI_CELESTIAL_VALID, 1.0, PEL_CIGI_CELESTIAL_STARS, (double)i,
             PEL_CIGI_CELESTIAL_EPHEMERIS, (double)i, PEL_CIGI_CELESTIAL_DATE,
             6212026.0, 0);
        send();
        const Pelagos__Sky *sky = pel_scene_state(scene)->sky;
        assert_true(sky->has_sun_elevation == (i == 0));
        assert_true(sky->has_sun_azimuth == (i == 0));
        assert_true(sky->has_moon_elevation == (i == 0));
        assert_true(sky->stars == (i == 1));
        const struct pel_snapshot *s = pel_scene_snapshot(scene);
        elevation[i] = asin(pel_snapshot_sun(s, pel_scene_time(scene)).z);
        pel_snapshot_unref(s);
    }
    /* The same Sun, to a frame's time: 7e-5 rad a second. */
    assert_near(elevation[0], elevation[1], 1e-5);
}

static void component(double id, double class, double instance, double state,
                      float first, float second)
{
    uint32_t words[2];
    memcpy(&words[0], &first, 4);
    memcpy(&words[1], &second, 4);
    with(PEL_CIGI_KIND_COMPONENT, PEL_CIGI_COMPONENT_ID, id,
         PEL_CIGI_COMPONENT_CLASS, class, PEL_CIGI_COMPONENT_INSTANCE, instance,
         PEL_CIGI_COMPONENT_STATE, state, PEL_CIGI_COMPONENT_DATA1,
         (double)words[0], PEL_CIGI_COMPONENT_DATA2, (double)words[1], 0);
}

static void components_of_a_region(void **state)
{
    (void)state;
    begin();
    component(1, 7, 0, 0, 6, 100);
    component(1, 4, 3, 1, 15, 200); /* wind of region 3, not its spectrum */
    component(17, 4, 3, 1, 2, 12);  /* swell train 1 there */
    with(PEL_CIGI_KIND_REGION, PEL_CIGI_REGION_ID, 3.0, PEL_CIGI_REGION_STATE,
         1.0, PEL_CIGI_REGION_LATITUDE, 52.6, PEL_CIGI_REGION_LONGITUDE, 5.2,
         PEL_CIGI_REGION_X, 2000.0, PEL_CIGI_REGION_Y, 2000.0, 0);
    send();
    const Pelagos__Sea *sea = pel_scene_state(scene)->sea;
    assert_near(sea->wind_speed, 15, 0);
    assert_int_equal(sea->spectrum, PELAGOS__SPECTRUM_KIND__PIERSON_MOSKOWITZ);
    assert_int_equal(sea->n_swell, 1);
    assert_near(sea->swell[0]->height, 2, 0);
    begin();
    component(5, 4, 3, 1, 0, 0);  /* there is one synthesiser */
    component(1, 12, 0, 0, 9, 9); /* event */
    place_ship(1, 52.7, 0);
    send();
    begin();
    send();
    assert_near(pel_scene_state(scene)->sea->wind_speed, 6, 0);
    assert_int_equal(pel_cigi_counters(cigi)->skipped_packets, 2);
}

static void components_light_lamps(void **state)
{
    (void)state;
    begin();
    place_ship(40, 52.61, 0);
    component(1, 0, 40, 2, 0, 0);    /* lights on */
    component(2, 0, 40, 11, 0, 0);   /* towing */
    component(3, 0, 40, 1, 0, 0);    /* deck lights */
    component(4, 0, 40, 1, 100, -5); /* searchlight */
    component(5, 0, 40, 0, 250, 0);  /* length of tow */
    component(1, 0, 41, 2, 0, 0);    /* who is not there */
    component(1, 0, 40, 3, 0, 0);    /* no such switch */
    component(2, 0, 40, 10, 0, 0);   /* reserved */
    component(9, 0, 40, 1, 0, 0);    /* no such component */
    send();
    const Pelagos__Entity *e = entity_of(scene, 40);
    assert_int_equal(e->lights, PELAGOS__LAMP_SWITCH__ON);
    assert_int_equal(e->navigation_status, PELAGOS__NAVIGATION_STATUS__TOWING);
    assert_true(e->deck_lights && e->searchlight->on);
    assert_near(e->searchlight->bearing, 100, 0);
    assert_near(e->searchlight->elevation, -5, 0);
    assert_near(e->searchlight->width, 3, 0); /* as it was */
    assert_near(e->tow_length, 250, 0);
    assert_int_equal(pel_cigi_counters(cigi)->skipped_packets, 4);
    begin();
    component(4, 0, 40, 0, 0, 0);
    component(1, 0, 40, 0, 0, 0);
    send();
    e = entity_of(scene, 40);
    assert_int_equal(e->lights, PELAGOS__LAMP_SWITCH__OFF);
    assert_false(e->searchlight->on);
    assert_int_equal(e->navigation_status, PELAGOS__NAVIGATION_STATUS__TOWING);
}

int main(void)
{
#define TEST(name)                                                             \
    cmocka_unit_test_setup_teardown(name, open_bridge, close_bridge)
    const struct CMUnitTest tests[] = {
        TEST(waves_are_of_the_sea),
        TEST(a_crest_stands_where_it_was_ordered),
        TEST(a_wavelength_gives_the_period),
        TEST(weather_is_of_the_region_the_view_is_in),
        TEST(lightning_is_a_layers),
        TEST(layers_are_fog_and_clouds),
        TEST(a_region_is_an_area),
        TEST(weather_goes_over_across_the_transition),
        TEST(components_give_whole_sea_states),
        TEST(components_of_a_region),
        TEST(components_light_lamps),
        TEST(the_sun_stands_without_ephemeris),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
