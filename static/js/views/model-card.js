// @ts-check
/** One model version: its origin, its figures beside the earlier ones, and actions. */

import { regressions, figureGroups } from '../model/model_figures.js';
import { isActive, partOf, stateWords } from './output-words.js';
import { fill, h, setText } from './dom.js';
import { figure, moment, percent } from '../model/format.js';
import { icon } from './icons.js';
import { createMeter, setMeter } from './meter.js';
import { lineage, modelProgress, VERDICTS } from './model-words.js';

/** @typedef {import('../types.js').ModelVersion} ModelVersion */
/** @typedef {import('../model/model_figures.js').FigureGroup} FigureGroup */
/** @typedef {import('../model/model_figures.js').FigureRow} FigureRow */
/** @typedef {{promote: (version: ModelVersion) => void, cancel: (version: ModelVersion) => void, resume: (version: ModelVersion) => void, remove: (version: ModelVersion) => void}} Acts */

/**
 * @param {ModelVersion} first
 * @param {Acts} acts
 * @returns {{element: HTMLLIElement, show: (version: ModelVersion, all: readonly ModelVersion[]) => void}}
 */
export function createModelCard(first, acts) {
  const title = h('h2.truncate', { id: `model-${first.id}` });
  const badge = h('span.badge');
  const used = h('span.badge.badge-accent', icon('check'), 'in use');
  const when = h('span.muted.small');
  const actions = h('div.row.model-actions');
  const words = h('p.small');
  const bar = createMeter(`Progress of ${first.name}`);
  const origin = h('dl.origin');
  const figures = h('div.model-figures');
  const element = h(
    'li.model',
    { 'aria-labelledby': title.id },
    h('div.row.model-head', title, badge, used, h('span.grow'), when, actions),
    words,
    bar,
    h('div.model-body', origin, figures),
  );
  /** @type {ModelVersion|null} */
  let shown = null;
  let actionsKey = '';

  /** @param {ModelVersion} version @param {readonly ModelVersion[]} all */
  function show(version, all) {
    if (version === shown) return;
    const before = shown;
    shown = version;
    const [text, tone] = stateWords(version);
    setText(title, version.name);
    setText(badge, text);
    badge.className = `badge ${tone}`;
    used.hidden = !version.active;
    setText(when, moment(version.finished ?? version.created));
    const active = isActive(version);
    const part = partOf(version);
    words.hidden = !active && version.state !== 'failed';
    setText(
      words,
      active ? modelProgress(version) : (version.error ?? 'It failed without saying why; the terminal of the server has more.'),
    );
    words.classList.toggle('field-error', version.state === 'failed');
    bar.hidden = !active;
    setMeter(bar, part);
    if (before?.lineage !== version.lineage)
      fill(origin, ...lineage(version, all).flatMap(([name, value]) => [h('dt', name), h('dd', value)]));
    if (before?.figures !== version.figures) fill(figures, ...figuresOf(version));
    const key = `${version.state} ${version.active}`;
    if (key !== actionsKey) fill(actions, ...actionsOf(version, acts));
    actionsKey = key;
  }

  return { element, show };
}

/** @param {ModelVersion} version */
function figuresOf(version) {
  const groups = figureGroups(version.figures);
  if (groups.length === 0) return [version.state === 'complete' ? h('p.muted.small', 'No figures: no data could be held out.') : null];
  const worse = regressions(version.figures);
  return [
    worse.length > 0 &&
      h(
        'div.import-refused',
        { role: 'note' },
        icon('alert'),
        h('div.stack', h('strong', 'Not everything got better'), ...worse.map((text) => h('p.small', text))),
      ),
    ...groups.map(table),
  ];
}

/** @param {FigureGroup} group */
function table({ name, title, note, of, rows }) {
  const compared = rows.some(({ before }) => before !== null);
  return h(
    'section',
    { class: `stack ${compared ? 'figures-compared' : ''}`, 'aria-label': title },
    h(
      'table.table',
      h('caption', h('strong', title), (note || of) && h('span.muted.small', ` ${[note, of].filter(Boolean).join(' ')}`)),
      h(
        'thead',
        h(
          'tr',
          h('th', { scope: 'col' }, 'Figure'),
          h('th.number', { scope: 'col' }, compared ? 'This version' : 'Value'),
          compared && h('th.number', { scope: 'col' }, 'Before'),
          compared && h('th', { scope: 'col' }, 'Change'),
        ),
      ),
      h(
        'tbody',
        ...rows.map((row) =>
          h(
            'tr',
            { dataset: { figure: `${name}/${row.name}` } },
            h('th', { scope: 'row' }, row.label),
            h('td.number', value(row, row.now)),
            compared && h('td.number', value(row, row.before)),
            compared && h('td', { class: `verdict verdict-${row.verdict}` }, verdict(row)),
          ),
        ),
      ),
    ),
  );
}

/** @param {FigureRow} row @param {number|null} number */
const value = (row, number) => (row.share ? percent(number) : figure(number));

/** @param {FigureRow} row */
function verdict(row) {
  if (row.verdict === null) return '';
  const [sign, word] = VERDICTS[row.verdict];
  if (row.before === null || row.verdict === 'same') return `${sign} ${word}`;
  const change = row.now - row.before;
  const size = row.share ? `${Math.abs(change * 100).toFixed(1)} points` : figure(Math.abs(change), 2);
  return `${sign} ${word} by ${size}`;
}

/**
 * @param {ModelVersion} version
 * @param {Acts} acts
 */
function actionsOf(version, acts) {
  /** @param {string} label @param {() => void} act @param {string} [more] */
  const button = (label, act, more = '') =>
    h('button', { class: `btn btn-small ${more}`, 'aria-label': `${label} ${version.name}`, onclick: act }, label);
  if (isActive(version)) return [button('Cancel', () => acts.cancel(version))];
  return [
    version.state === 'complete' && !version.active && button('Promote', () => acts.promote(version), 'btn-primary'),
    (version.state === 'failed' || version.state === 'cancelled') && button('Make again', () => acts.resume(version)),
    version.id !== 'shipped' &&
      h(
        'button.btn.btn-small.btn-quiet.btn-icon',
        { 'aria-label': `Delete ${version.name}`, title: 'Delete …', onclick: () => acts.remove(version) },
        icon('trash'),
      ),
  ];
}
