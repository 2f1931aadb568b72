/* Reflection by a rough sea: Fresnel and the Ross BRDF, double precision. What
 * is called pel_ross_ is the papers', as printed but for corrections;
 * pel_fresnel_exact and pel_glitter are what is drawn. Twins in
 * shaders/lib/ross.glsl: pel_fresnel_exact (facet_reflectance),
 * pel_ross_slope_density (slope_density), pel_ross_lambda of pel_ross_a
 * (smith_lambda_cos, times the cosine), pel_sharpened (sharpened),
 * pel_ross_mean_fresnel (mean_fresnel), pel_glitter (reflected_light),
 * pel_seen_steeper, pel_escape (escape); in shaders/probe.comp:
 * pel_mean_fresnel (smith_fresnel). Any thread.
 *
 * Directions are unit vectors in the surface's tangent frame: z the normal,
 * x along the wind. Slope variances are dimensionless. */
#pragma once

#include "base/vec.h"
#include "shaders/lib/blocks.h"

/* Reflectance of unpolarised light at a flat surface, from air into index n:
 * Fresnel's equations, which every reflection follows; cos_theta in [0, 1]. */
double pel_fresnel_exact(double cos_theta, double n);

/* Schlick 1994: R + (1 − R)(1 − cos θ)^5, R = ((n−1)/(n+1))²
 * (Bruneton et al. 2010, eq. 14). Only to compare with the paper. */
double pel_fresnel_schlick(double cos_theta, double n);

/* What the displacement of water towards crests makes of the density of slopes,
 * over the normal one of the waves without it: steep and level facets are more,
 * those between fewer. A surface x + D(x) of Gaussian height and displacement
 * (the choppy waves of Nouguier, Guérin and Chapron 2009) has the slopes J⁻¹ζ
 * on the area |J|, J = 1 + ∇D, so that p(ζ) = E[|J|² p0(Jζ)]; here for waves of
 * all directions alike, whose ∇D has 3/8, 1/8 and 1/8 of fold · 4/3 times the
 * slope variance along, across and mixed, |J| by its mean where Jζ is met.
 * fold: 3/4 of the waves' squared chop (pel_sea_folding). var without a
 * light's disc, which widens what mirrors it alone.
 *
 * Where other waves carry these, a facet has the slopes `whole` of both, `own`
 * at rest of these alone (pel_own_slope), and their ∇D presses all of them:
 * E[|J|² p0(own + ∇D whole)]. Without others both are the same. */
double pel_sharpened(struct pel_vec2 own, struct pel_vec2 whole, double var_x,
                     double var_y, double disc, double fold);

/* A patch of sea with the mean normal of the waves that are resolved there, and
 * by how much these press the water of others together: ∂p.x/∂x, ∂p.y/∂x,
 * ∂p.x/∂y, ∂p.y/∂y of its places p by those at rest. x along the wind. */
struct pel_patch {
    struct pel_vec3 along, across, normal; /* orthonormal; z is up */
    double pressed[4];
};

/* Slopes of waves add at rest: a surface x + D(x) has the slopes J⁻¹ζ, J = 1 +
 * ∇D. Of a facet of slopes s in the frame of a patch (its normal is s.x along +
 * s.y across + normal) the slopes ζ of the waves that the patch leaves out,
 * with the signs of that normal; returned: ∂ζ/∂s, their area by that of s. So
 * the density of s is that of ζ times it. */
double pel_own_slope(const struct pel_patch *patch, struct pel_vec2 s,
                     struct pel_vec2 *own);

/* Gaussian slope density p(ζ), eq. 7. */
double pel_ross_slope_density(double zx, double zy, double var_x, double var_y);

/* Smith's Λ(a), eq. 8; a > 0; → 0 for large a. */
double pel_ross_lambda(double a);

/* a(θ, φ) = 1 / (√2 s tan θ), s² = σx² cos²φ + σy² sin²φ: eq. 9 corrected.
 * Infinite for a view along the normal or a flat surface. */
double pel_ross_a(struct pel_vec3 dir, double var_x, double var_y);

/* Visible slope density q^e_vn, eq. 10: integrates to 1 over slopes. */
double pel_ross_visible_density(double zx, double zy, struct pel_vec3 view,
                                double var_x, double var_y);

/* The BRDF, eq. 13 with 4 h_z³ and cos θ_l, Fresnel by Schlick [1/sr]. */
double pel_ross_brdf(struct pel_vec3 view, struct pel_vec3 light, double var_x,
                     double var_y);

/* Radiance reflected from a sun of unit irradiance normal to its beam [1/sr]:
 * eq. 15 with L_sun Ω_sun = 1, variances clamped to `min_variance`; times E it
 * is the radiance. 0 for a view or light below the surface. */
double pel_ross_sun(struct pel_vec3 view, struct pel_vec3 light, double var_x,
                    double var_y, double min_variance);

/* By how many standard deviations facets that are seen at μ = cot θ / s are
 * steeper towards the eye than Smith's masking has them (PEL_SEEN_STEEPER). */
double pel_seen_steeper(double mu);

/* By how much of it the inverse variance of their slopes is greater. */
double pel_seen_narrower(double mu);

/* Of the light that facets seen at μ mirror at an elevation of tangent eta s,
 * the part that no other wave meets; 0 below the horizon. */
double pel_escape(double eta, double mu);

/* The same as it is drawn: pel_ross_sun with the facets that are seen
 * (pel_seen_steeper), pel_escape in place of the light's Λ, and `disc`, the
 * variance of slopes that mirror some of a light's disc (a sixteenth of its
 * squared angular radius), added to the density's variances in place of a
 * clamp; Fresnel's equations with index n; crests sharpened by `fold`
 * (pel_sharpened; 0: normal slopes). */
double pel_glitter(struct pel_vec3 view, struct pel_vec3 light, double var_x,
                   double var_y, double disc, double n, double fold);

/* Effective reflectance F̄ by Smith's masking: eq. 24, with Fresnel's equations,
 * by midpoints (PEL_MEAN_FRESNEL_STEPS a side); within 1e-3. view.z
 * > 0. */
double pel_mean_fresnel(struct pel_vec3 view, double var_x, double var_y,
                        double n);

/* The same by the fit of eq. 26, Schlick's term inside it. */
double pel_ross_mean_fresnel(struct pel_vec3 view, double var_x, double var_y);
