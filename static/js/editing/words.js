// @ts-check
/** What the commands are called. */

/** @type {Record<string, string>} */
const NAMES = {
  create_track: 'New track',
  set_box: 'Box corrected',
  relabel_track: 'Track relabelled',
  relabel_box: 'Box relabelled',
  merge: 'Tracks merged',
  split: 'Track split',
  delete_from: 'Track cut off',
  delete_track: 'Track deleted',
  add_key: 'Key frame set',
  remove_key: 'Key frame removed',
  interpolate: 'Boxes interpolated',
  set_occluded: 'Occlusion marked',
  set_outside: 'Out of sight marked',
  set_not_a_sign: 'Marked as no sign',
  set_review: 'Verdict',
  add_note: 'Note pinned',
  edit_note: 'Note changed',
  remove_note: 'Note removed',
  undo: 'Undo',
  redo: 'Redo',
};

/** @param {string} name of a command @returns {string} */
export const describe = (name) => NAMES[name] ?? name;
