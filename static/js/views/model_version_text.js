// @ts-check
/** Texts about model versions: origin, progress, and the version of a run. Pure functions. */

import { count, plural } from '../model/format.js';

/** @typedef {import('../types.js').ModelVersion} ModelVersion */

/** Names of the parts of a version. @type {Record<string, string>} */
export const PART_NAMES = {
  detector: 'Detector',
  prior: 'Spatial prior',
  lambda: 'Weight of the prior',
  classifier: 'Classifier',
  online: 'Start of the online detector',
};

/** Symbol and word of a change. @type {Record<import('../model/model_figures.js').Verdict, [string, string]>} */
export const VERDICTS = { better: ['▲', 'better'], worse: ['▼', 'worse'], same: ['=', 'same'], new: ['+', 'new'] };

/** @param {ModelVersion} version @returns {string} its progress in words */
export function describeProgress(version) {
  if (version.state === 'queued') return 'Waiting for a free worker.';
  const steps = version.total ? ` · ${count(version.done)} of ${count(version.total)}` : '';
  return `${version.stage || 'starts'}${steps}${version.note && ` · ${version.note}`}`;
}

/**
 * The origin of a version, as pairs of a heading and a text.
 *
 * @param {ModelVersion} version
 * @param {readonly ModelVersion[]} all
 * @returns {[string, string][]}
 */
export function describeLineage(version, all) {
  const { lineage: origin } = version;
  if (version.id === 'shipped') return [['Origin', 'the engine: trained on public data, without corrections'], ...labelRows(version)];
  const request = origin.asked ?? {};
  const rows = /** @type {[string, string][]} */ ([]);
  const parent =
    version.parent_id === null ? 'Shipped' : (all.find(({ id }) => id === version.parent_id)?.name ?? 'a version that was removed');
  rows.push(['Made from', parent]);
  const reviews = joinNames(request.reviews, (one) => one.name);
  if (reviews) rows.push(['Reviews', reviews]);
  const exports = joinNames(request.exports, (one) => one.name ?? one.artefact);
  if (exports) rows.push(['Exports', exports]);
  const edits = joinNames(origin.exports, editsOf);
  if (edits) rows.push(['Corrections', edits]);
  const folders = Object.entries(request.folders ?? {})
    .map(([name, path]) => `${name.toUpperCase()} in ${path}`)
    .join(', ');
  if (folders) rows.push(['Data', folders]);
  rows.push(['Parts', (origin.parts ?? request.parts ?? []).map((/** @type {string} */ name) => PART_NAMES[name] ?? name).join(', ')]);
  rows.push(['Seed', String(origin.seed ?? request.seed ?? 0)]);
  const used = origin.used;
  if (used && typeof used.frames === 'number')
    rows.push(['Learned from', `${plural(used.signs ?? 0, 'sign')} in ${plural(used.frames, 'frame')} of ${videosOf(used.videos ?? [])}`]);
  if (origin.held_out?.by && origin.held_out.by !== 'none')
    rows.push([
      'Measured on',
      `${plural((origin.held_out.signs ?? []).length, 'sign')}, chosen by ${origin.held_out.by}, with a trial version trained without ${(origin.held_out.signs ?? []).length === 1 ? 'it' : 'them'}`,
    ]);
  if (origin.notes?.length) rows.push(['Left out', origin.notes.join(' ')]);
  return [...rows, ...labelRows(version)];
}

/** Maximum number of missing labels to name. */
const MAX_NAMED_LABELS = 8;

/** The labels that a version can read. @param {Pick<ModelVersion, 'labels'|'lacks'>} version @returns {[string, string][]} */
function labelRows({ labels, lacks }) {
  if (labels === undefined || lacks === undefined) return [];
  const more = lacks.length > MAX_NAMED_LABELS ? ` and ${count(lacks.length - MAX_NAMED_LABELS)} more` : '';
  return [
    [
      'Labels',
      `${count(labels)}${lacks.length > 0 ? `; it lacks these of the label set: ${lacks.slice(0, MAX_NAMED_LABELS).join(', ')}${more}` : '; all signs of the label set'}`,
    ],
  ];
}

/** Parts that a run uses, as in app/training/folders.py. A run may list others, such as an ONNX network. */
const MODEL_PARTS = ['detector', 'prior', 'classifier', 'network_classifier', 'online'];

/**
 * The version that made a run: the one with the same files.
 *
 * @param {Pick<import('../types.js').Run, 'models'>} run
 * @param {readonly ModelVersion[]|null} versions   null: not loaded
 * @returns {string|null} its name; null: no version has these files any more; empty: the run used no models, or versions are not known
 */
function versionOf({ models }, versions) {
  const parts = MODEL_PARTS.filter((part) => models[part]);
  if (parts.length === 0 || versions === null) return '';
  return versions.find((version) => parts.every((part) => version.models[part] === models[part]))?.name ?? null;
}

/**
 * The models of a run, for its description.
 *
 * @param {Pick<import('../types.js').Run, 'models'>} run
 * @param {readonly ModelVersion[]|null} versions   null: not loaded
 * @returns {string} empty: it used no models, or versions are not known
 */
export function describeRunModels(run, versions) {
  const name = versionOf(run, versions);
  return name === null ? 'Models that were removed' : name && `Models: ${name}`;
}

/**
 * The same in short, for lists of runs. Empty if there is only one version.
 *
 * @param {Pick<import('../types.js').Run, 'models'>} run
 * @param {readonly ModelVersion[]|null} versions   null: not loaded
 * @returns {string} ` · Version 2`, or empty
 */
export function modelVersionSuffix(run, versions) {
  const name = (versions ?? []).filter(({ state }) => state === 'complete').length > 1 && versionOf(run, versions);
  return name ? ` · ${name}` : '';
}

/** The name of a single video, unless only its hash is known; else the number of videos. @param {string[]} videos */
const videosOf = (videos) => (videos.length === 1 && !/^[0-9a-f]{64}$/.test(videos[0]) ? videos[0] : plural(videos.length, 'video'));

/** @param {unknown} list @param {(one: any) => unknown} name */
const joinNames = (list, name) =>
  Array.isArray(list) ? [...new Set(list.map((one) => String(name(one) ?? '')))].filter(Boolean).join(', ') : '';

/** The state of the corrections in a review or an export, and the edits and undos since. @param {any} source */
function editsOf(source) {
  const runs = Array.isArray(source?.runs) ? source.runs : [];
  const corrections = runs
    .map((/** @type {any} */ one, /** @type {number} */ at) =>
      typeof one?.edit_revision === 'number' ? `${source.names?.[at] ?? 'a video'} up to edit ${one.edit_revision}` : '',
    )
    .filter(Boolean)
    .join(', ');
  const since = [
    source?.edits_since > 0 && `${plural(source.edits_since, 'edit')} made since`,
    source?.undone_since > 0 && `${plural(source.undone_since, 'edit')} of it undone since`,
  ]
    .filter(Boolean)
    .join(', ');
  return since ? `${corrections} (${since})` : corrections;
}
