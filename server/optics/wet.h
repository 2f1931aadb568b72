/* What waves that wash over a hull leave on it. Pure functions, any thread;
 * twins of shaders/lib/wet.glsl. */
#pragma once

/* Standard deviation of the sea's height against a hull of this length, m, in a
 * sea of variance m0, m²: a hull goes along with waves of more than twice its
 * length. Of deep water's wind waves with Phillips' tail of 0.0081, by the
 * integral of the spectrum of Pierson and Moskowitz 1964 above a wavenumber. */
double pel_wet_deviation(double m0, double length_m);

/* Share of a hull that is wet so high above its waterline: the chance that the
 * highest of PEL_WET_WAVES (shaders/lib/blocks.h) crests came there, which are
 * distributed as Rayleigh has it (Longuet-Higgins 1952). 1 below it. */
double pel_wet_share(double above_m, double deviation_m);

/* Reflectance of a matt surface under a film of water (Lekner and Dorf 1988,
 * eq. 1 and 9): part of the light that it sends up is thrown back to it. */
double pel_wet_reflectance(double dry);
