// @ts-check
/** Line icons of 16 x 16, drawn in the colour of the text. Every icon has a label or a text beside it. */

import { h, s } from './dom.js';

/** Paths by name. */
const PATHS = /** @type {const} */ ({
  accept: 'M3 8.5 6.5 12 13 4.5',
  add: 'M8 3v10M3 8h10',
  alert: 'M8 2 15 14H1ZM8 6.5v3.5M8 12v.01',
  bug: 'M5.5 6a2.5 2.5 0 0 1 5 0v4a2.5 2.5 0 0 1-5 0ZM5.5 8h-4M14.5 8h-4M5.7 5.2 3 3M10.3 5.2 13 3M5.7 10.8 3 13M10.3 10.8 13 13M8 6v6',
  box: 'M2.5 4.5h11v7h-11Z',
  check: 'M3 8.5 6.5 12 13 4.5',
  close: 'M4 4l8 8M12 4l-8 8',
  compare: 'M2.5 3h4.5v10H2.5ZM9 3h4.5v10H9Z',
  contrast: 'M8 1.5a6.5 6.5 0 1 0 .01 0M8 1.5v13M8 4.5h3.7M8 8h6M8 11.5h3.7',
  cube: 'M8 1.5 14 5v6l-6 3.5L2 11V5ZM2 5l6 3.5L14 5M8 8.5v6',
  delete: 'M3 4.5h10M6.5 4.5V2.5h3v2M4.5 4.5 5 13.5h6l.5-9',
  delete_from: 'M2 4.5h6M2 11.5h6M10 5.5l4 5M14 5.5l-4 5',
  uncertainty: 'M5.5 6a2.5 2.5 0 1 1 3.5 2.3c-.7.4-1 .8-1 1.7M8 12.5v.01',
  down: 'M3.5 6 8 10.5 12.5 6',
  draw: 'M3 5V3h2M11 3h2v2M13 11v2h-2M5 13H3v-2M8 5.5v5M5.5 8h5',
  export: 'M8 9.5v-7.5M4.8 5 8 1.8 11.2 5M3 8v6h10V8',
  eye: 'M1.5 8S4 3.5 8 3.5 14.5 8 14.5 8 12 12.5 8 12.5 1.5 8 1.5 8ZM8 6.2a1.8 1.8 0 1 0 .01 0',
  filter: 'M2 3h12l-4.5 5.5V13l-3-1.5v-3Z',
  follow: 'M5.5 5h5v6h-5ZM3.5 8H1M12.5 8H15M2.5 6.5 1 8l1.5 1.5M13.5 6.5 15 8l-1.5 1.5',
  film: 'M2 3h12v10H2ZM5 3v10M11 3v10M2 6.3h3M2 9.7h3M11 6.3h3M11 9.7h3',
  fit: 'M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10',
  extend_first: 'M13.5 4.5h-5v7h5M6 8H1.5M3.5 5.5 1.5 8l2 2.5',
  extend_last: 'M2.5 4.5h5v7h-5M10 8h4.5M12.5 5.5l2 2.5-2 2.5',
  grid: 'M2.5 2.5h4.5v4.5h-4.5ZM9 2.5h4.5v4.5H9ZM2.5 9h4.5v4.5h-4.5ZM9 9h4.5v4.5H9Z',
  rows: 'M2.5 4h11M2.5 8h11M2.5 12h11',
  folder: 'M1.5 4V12.5h13V5.5H8L6.5 3.5h-5Z',
  forward: 'M6.5 3.5 11 8l-4.5 4.5',
  help: 'M8 1.5a6.5 6.5 0 1 0 .01 0M6 6.3a2 2 0 1 1 2.9 1.8c-.6.3-.9.7-.9 1.4M8 11.7v.01',
  import: 'M8 1.8v7.7M4.8 6.5 8 9.7l3.2-3.2M3 8v6h10V8',
  info: 'M8 1.5a6.5 6.5 0 1 0 .01 0M8 7v4.5M8 4.5v.01',
  interpolate: 'M2 12.5 14 3.5M2 12.5m-1 0a1 1 0 1 0 2 0 1 1 0 1 0-2 0M14 3.5m-1 0a1 1 0 1 0 2 0 1 1 0 1 0-2 0',
  key: 'M8 2.5 13.5 8 8 13.5 2.5 8Z',
  leave: 'M9.5 2.5H3v11h6.5M6.5 8h8M12 5.5 14.5 8 12 10.5',
  label: 'M2 3.5h7L14 8l-5 4.5H2ZM5 8h.01',
  layers: 'M8 2 14.5 5.5 8 9 1.5 5.5ZM1.5 8.5 8 12l6.5-3.5M1.5 11.5 8 15l6.5-3.5',
  merge: 'M3 3c0 4 5 3 5 7v3.5M13 3c0 4-5 3-5 7M5.5 11 8 13.5 10.5 11',
  moon: 'M13.5 10A6 6 0 0 1 6 2.5a6 6 0 1 0 7.5 7.5Z',
  needs_work: 'M8 1.5a6.5 6.5 0 1 0 .01 0M8 4.5V8l2.5 2',
  new_box: 'M2.5 4.5h11v7h-11ZM8 6.5v3M6.5 8h3',
  next: 'M4 3.5 9.5 8 4 12.5ZM12 3.5v9',
  note: 'M2.5 2.5h11v8L10 13.5H2.5ZM5 6h6M5 8.5h4',
  occluded: 'M2.5 5h7v7h-7ZM6 5V2.5h7.5V10H9.5',
  offline: 'M2 2l12 12M4 9a5.5 5.5 0 0 1 2-1.6M12 9a5.5 5.5 0 0 0-2.5-1.7M1.5 6.5A9 9 0 0 1 4.5 4.5M14.5 6.5A9 9 0 0 0 7 3.8M8 12.5v.01',
  outside: 'M2.5 4.5h11v7h-11ZM2 14 14 2',
  pause: 'M5 3v10M11 3v10',
  person: 'M8 2a2.8 2.8 0 1 0 .01 0M2.5 14a5.5 5.5 0 0 1 11 0',
  play: 'M4.5 3 12.5 8l-8 5Z',
  previous: 'M12 3.5 6.5 8l5.5 4.5ZM4 3.5v9',
  record: 'M8 2a6 6 0 1 0 .01 0M8 5.5a2.5 2.5 0 1 0 .01 0',
  redo: 'M10 2.5 13.5 6 10 9.5M13.5 6H6.5a4 4 0 0 0 0 8H8',
  refresh: 'M13.5 8A5.5 5.5 0 1 1 11.7 4M13.5 2v3.5H10',
  reject: 'M4 4l8 8M12 4l-8 8',
  run: 'M8 1.5a6.5 6.5 0 1 0 .01 0M6.5 5.5v5L10.5 8Z',
  saved: 'M4.5 12.5a3 3 0 0 1-.3-6 4 4 0 0 1 7.6 0 3 3 0 0 1-.3 6ZM6 9.3l1.5 1.4L10.2 8',
  search: 'M7 2.5a4.5 4.5 0 1 0 .01 0M10.5 10.5 14 14',
  select: 'M3.5 2.5 12.5 8l-4 1-2 4Z',
  settings: 'M2 4.5h7M13 4.5h1M2 11.5h1M7 11.5h7M11 3v3M5 10v3',
  sort: 'M4.5 3v10M2 10.5 4.5 13 7 10.5M9 4h5M9 8h3.5M9 12h2',
  split: 'M8 2v4M8 6C8 9.5 3 9 3 13.5M8 6c0 3.5 5 3 5 7.5',
  step_back: 'M10.5 3.5 5.5 8l5 4.5Z',
  step_forward: 'M5.5 3.5 10.5 8l-5 4.5Z',
  stop: 'M3.5 3.5h9v9h-9Z',
  cut: 'M4 2.5 11 11M12 2.5 5 11M4 11a1.7 1.7 0 1 0 .01 0M12 11a1.7 1.7 0 1 0 .01 0',
  key_back: 'M12.5 4v8L8.5 8ZM5 4.5 8 8l-3 3.5L2 8Z',
  key_forward: 'M3.5 4v8l4-4ZM11 4.5 14 8l-3 3.5L8 8Z',
  ignore: 'M8 2.5a5.5 5.5 0 1 0 .01 0M4.2 4.2l7.6 7.6',
  one_to_one: 'M3 5.5 4.5 4.5v7M11 5.5l1.5-1v7M8 6.5v.01M8 9.5v.01',
  skip_back: 'M13 3.5 8 8l5 4.5ZM7.5 3.5 2.5 8l5 4.5Z',
  skip_forward: 'M3 3.5 8 8l-5 4.5ZM8.5 3.5l5 4.5-5 4.5Z',
  sun: 'M8 5a3 3 0 1 0 .01 0M8 1v1.5M8 13.5V15M1 8h1.5M13.5 8H15M3 3l1 1M12 12l1 1M13 3l-1 1M4 12l-1 1',
  to_start: 'M13.5 8H5M8.5 4.5 5 8l3.5 3.5M2.5 3v10',
  truth: 'M2.5 4.5h11v7h-11ZM5 8l2 2 4-4',
  undo: 'M6 2.5 2.5 6 6 9.5M2.5 6h7a4 4 0 0 1 0 8H8',
  up: 'M3.5 10 8 5.5l4.5 4.5',
  upload: 'M8 10.5v-8M4.5 5.5 8 2l3.5 3.5M2 10.5v3h12v-3',
  whatif: 'M2 8h3l2-5 2.5 10L11.5 8H14',
  zoom_in: 'M7 2.5a4.5 4.5 0 1 0 .01 0M10.5 10.5 14 14M7 5v4M5 7h4',
  zoom_out: 'M7 2.5a4.5 4.5 0 1 0 .01 0M10.5 10.5 14 14M5 7h4',
});

/** @typedef {keyof typeof PATHS} IconName */

/**
 * @param {IconName} name
 * @returns {SVGSVGElement} decoration: hidden from screen readers
 */
export function icon(name) {
  return s('svg.icon', { viewBox: '0 0 16 16', 'aria-hidden': 'true', focusable: 'false' }, s('path', { d: PATHS[name] }));
}

/**
 * A small button without a border that shows only an icon.
 *
 * @param {IconName} name
 * @param {string} label     read by screen readers
 * @param {() => unknown} [onclick]
 * @param {string|null} [title]   tooltip; null: none
 */
export const iconButton = (name, label, onclick, title = label) =>
  h('button.btn.btn-quiet.btn-icon.btn-small', { 'aria-label': label, title, onclick }, icon(name));

/**
 * Whether there is an icon of that name; operations name theirs in a string.
 *
 * @param {string} name
 * @returns {name is IconName}
 */
export function isIcon(name) {
  return Object.hasOwn(PATHS, name);
}
