/* A scene that several daemons show (server/cluster): one of them takes the
 * edits and puts them into a log, the others are led by that log. Control
 * thread. */
#pragma once

#include "scene/scene.h"

/* --- led by a log --------------------------------------------------------- */

/* From now on simulated time stands, whatever clock.mode says, but for the
 * calls below; every other edit and step is refused: CONFLICT, with `cure` as
 * the message; nobody acts (pel_scene_add_acts). Patches that wait are refused
 * when their turn comes. May be called again with another cure. */
void pel_scene_lead(struct pel_scene *scene, const char *cure);

/* It leads itself again: its clock goes on from where it stands. */
void pel_scene_unlead(struct pel_scene *scene);

/* An entry as it was done: simulated time comes to exactly its time, then its
 * patch is applied whole. Its file is read here. CONFLICT: the time is before
 * the present one; else faults as of pel_scene_patch. */
PEL_CHECK enum pel_err pel_scene_play(struct pel_scene *scene,
                                      const Pelagos__LogEntry *entry,
                                      struct pel_fault *fault);

/* Simulated time comes to exactly time_s. CONFLICT as above. */
PEL_CHECK enum pel_err pel_scene_play_to(struct pel_scene *scene, double time_s,
                                         struct pel_fault *fault);

/* --- the one who takes the edits ------------------------------------------ */

/* The present moment for all to see: what acts at moments up to it has done so,
 * and the state (pel_scene_state_at) and the snapshot are of exactly it. */
double pel_scene_moment(struct pel_scene *scene);

/* The state as of time_s, not before any time that was asked for; as
 * pel_scene_state. */
const Pelagos__State *pel_scene_state_at(struct pel_scene *scene,
                                         double time_s);

/* A snapshot whose ships are at time_s; a new reference. */
const struct pel_snapshot *pel_scene_snapshot_at(struct pel_scene *scene,
                                                 double time_s);

/* The steps of the ships begin anew with the present state, as with a state
 * that is read: who begins with that state has the same motion. */
void pel_scene_anew(struct pel_scene *scene, double time_s);

/* --- the gate ------------------------------------------------------------- */

/* From now on edits and steps that were accepted (pel_scene_submit,
 * pel_scene_submit_step) are answered when frame `number` is sealed; refusals
 * at once. Called again with each frame that begins. */
void pel_scene_gate(struct pel_scene *scene, uint64_t number);

bool pel_scene_gated(const struct pel_scene *scene);

/* Frames up to this are sealed: what waits for them is answered. */
void pel_scene_sealed(struct pel_scene *scene, uint64_t number);

/* No frame will be: all that waits is refused with this fault, and the gate is
 * open. */
void pel_scene_ungate(struct pel_scene *scene, const struct pel_fault *fault);

/* `done` is called, with no fault, when what has been accepted by now is
 * sealed; false: there is no gate, and it has not been called. */
bool pel_scene_await(struct pel_scene *scene, const void *source,
                     pel_scene_done done, void *user);
