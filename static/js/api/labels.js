// @ts-check
/** Routes of label sets. */

import { encode, queryText } from './http.js';

/** @typedef {import('../types.js').LabelSetSummary} LabelSetHead */
/** @typedef {import('./http.js').Call} Call */
/** @typedef {import('../types.js').Label} Label */
/** @typedef {{version: number, label: Label|null, sentence: string}} LabelAnswer   `label`: the changed label */
/** @typedef {ReturnType<typeof labelRoutes>} LabelRoutes */
/** @typedef {{version: number, sentence: string, created: boolean, added: unknown[], known: unknown[], refused: {name: string, reason: string}[], reported: string[]}} ImportedLabels */

/** Defaults of fields that a label set may omit. */
const LABEL_DEFAULTS = {
  short: '',
  aliases: [],
  shape: 'other',
  category: 'other',
  size_mm: null,
  mirror: null,
  teach: 'sign',
  colour: null,
  pinned: null,
  hidden: false,
  merged_into: null,
};
const ATTRIBUTE_DEFAULTS = { mutable: false, values: [], low: null, high: null, default: null };
const LABEL = /** @type {const} */ ({
  id: 'number',
  key: 'string',
  name: 'string',
  picture: 'nullable',
  aliases: 'array',
  attributes: 'array',
});
const VERSION = /** @type {const} */ ({
  version: 'number',
  author: 'string',
  created: 'nullable',
  sentence: 'string',
  undoes: 'nullable',
});
const HEAD = /** @type {const} */ ({
  key: 'string',
  name: 'string',
  version: 'number',
  labels: 'number',
  default: 'boolean',
  shipped: 'boolean',
});

/** @param {import('./http.js').Routes} routes */
export const labelRoutes = ({ base, json, list, object }) => ({
  /** @param {string|null} [video]   labels of its set; null: of the library's default set @param {Call} [call] @returns {Promise<Label[]>} */
  labels: (video, call) => list('GET /labels', [], LABEL, { ...call, query: { video } }),
  /** @param {Call} [call] @returns {Promise<LabelSetHead[]>} */
  labelSets: (call) => list('GET /label-sets', [], HEAD, call),
  /** @param {string} set @param {Call} [call] @returns {Promise<Label[]>} all labels of a set, also hidden and merged ones */
  labelsOfSet: async (set, call) => {
    const labels = await list('GET /label-sets/…', [set], { id: 'number', key: 'string', name: 'string' }, call, 'labels');
    return labels.map((label) => ({
      ...LABEL_DEFAULTS,
      ...label,
      attributes: (label.attributes ?? []).map((/** @type {any} */ one) => ({ ...ATTRIBUTE_DEFAULTS, ...one })),
      picture: label.pictogram ? `${base}/labels/${label.id}.png${queryText({ set, size: 64, look: label.pictogram.slice(-60) })}` : null,
    }));
  },
  /** @param {string} set @param {Call} [call] @returns {Promise<import('../types.js').LabelUsage>} */
  labelUsage: (set, call) => object('GET /label-sets/…/usage', [set], { labels: 'object', unread: 'number' }, { timeout: 60_000, ...call }),
  /** @param {string} set @param {Call} [call] @returns {Promise<import('../types.js').LabelVersion[]>} newest first */
  labelHistory: (set, call) => list('GET /label-sets/…/history', [set], VERSION, call),
  /** @param {string} set @param {string} format @returns {string} address of the file */
  labelFileUrl: (set, format) => `${base}/label-sets/${encode(set)}/file${queryText({ format })}`,
  /** @param {string} set @param {string} author @param {import('../types.js').LabelChange} change @param {Call} [call] @returns {Promise<LabelAnswer>} */
  changeLabels: (set, author, change, call) =>
    object(
      'POST /label-sets/…/changes',
      [set],
      { version: 'number', label: 'nullable', sentence: 'string' },
      { ...call, body: { author, change } },
    ),
  /** @param {string} set @param {File} file @param {string} author @param {boolean} create   make the set if it does not exist @param {Call} [call] @returns {Promise<ImportedLabels>} */
  importLabels: (set, file, author, create, call) =>
    object(
      'POST /label-sets/…/files',
      [set],
      { sentence: 'string', added: 'array', known: 'array', refused: 'array', reported: 'array' },
      {
        timeout: 60_000,
        ...call,
        body: file,
        type: 'application/octet-stream',
        query: { author, name: file.name.slice(-120), create: create ? 'true' : null },
      },
    ),
  /** @param {string} video @param {string|null} set   null: the library's default @param {Call} [call] @returns {Promise<unknown>} */
  useLabelSet: (video, set, call) => json('PUT /videos/…/label-set', [video], { ...call, body: { set } }),
  /** @param {string} set @param {Call} [call] @returns {Promise<unknown>} */
  setDefaultLabelSet: (set, call) => json('PUT /label-sets/default', [], { ...call, body: { set } }),
});
