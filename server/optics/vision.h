/* How an eye sees by little light: rods and cones. Any thread. */
#pragma once

/* V'(λ) of the CIE 1951 scotopic observer, linear between 5 nm; 0 beyond 380
 * and 680 nm. */
double pel_vision_rods(double nm);

/* Cones' share m, 0..1, for photopic and scotopic luminances [cd/m²]: CIE
 * 191:2010, where its iteration ends, by six steps of Newton's (within 0.01 of
 * its end for S/P to 4).
 */
double pel_vision_cones(double photopic, double scotopic);

/* Mesopic luminance [cd/m²], the same. */
double pel_vision_luminance(double photopic, double scotopic);

/* Light of linear Rec. 709 [cd/m²] and scotopic luminance as an eye sees it:
 * what the cones have keeps its colour, the rods' is a pale blue (Krawczyk,
 * Myszkowski and Seidel 2005, eq. 13). Its luminance is the mesopic one. */
void pel_vision_seen(const double rec709[3], double scotopic, double out[3]);

/* How far an eye adapted to a luminance [cd/m²] is from where its rods see
 * contrast by Weber's law, 0..1: of luminance over threshold (Ferwerda et al.
 * 1996), 1 from 0.036 cd/m² on. */
double pel_vision_sight(double adapted);

/* The finest grating that an eye adapted to a luminance [cd/m²] tells from grey
 * [cycles a degree]: Shlaer 1937 as Ward, Rushmeier and Piatko 1997 fit it; 1.9
 * at 1e-4 and below, 44 at 10. */
double pel_vision_acuity(double adapted);

/* Deviation [rad] of the Gaussian by which such an eye spreads what one adapted
 * to 10 cd/m² sees: with that one's own, such a grating keeps half of its
 * contrast (Ferwerda et al. 1996). 0 from there on. */
double pel_vision_blur(double adapted);

/* pel_meter_ev of an eye: its key is Krawczyk's as it stands, times
 * PEL_METER_KEY, and by PEL_EYE_FALL less where the root of pel_vision_sight
 * goes to 0; its least EV PEL_EYE_LEAST. Mesopic luminances. */
double pel_vision_ev(double mean, double high, double level_lx);
