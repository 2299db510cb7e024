// @ts-check
/** One model version: its origin, its figures beside the earlier ones, and actions. */

import { regressions, figureGroups } from '../model/model_figures.js';
import { isActive, progressOf, stateBadge } from './output_text.js';
import { fill, h, setText } from './dom.js';
import { figure, moment, percent } from '../model/format.js';
import { icon, iconButton } from './icons.js';
import { createProgressBar, setProgress } from './progress_bar.js';
import { VERDICTS, describeLineage, describeProgress } from './model_version_text.js';

/** @typedef {import('../types.js').ModelVersion} ModelVersion */
/** @typedef {import('../model/model_figures.js').FigureGroup} FigureGroup */
/** @typedef {import('../model/model_figures.js').FigureRow} FigureRow */
/** @typedef {{promote: (version: ModelVersion) => void, cancel: (version: ModelVersion) => void, resume: (version: ModelVersion) => void, remove: (version: ModelVersion) => void}} ModelActions */

/**
 * @param {ModelVersion} initialVersion
 * @param {ModelActions} onAction
 * @returns {{element: HTMLLIElement, show: (version: ModelVersion, all: readonly ModelVersion[]) => void}}
 */
export function createModelCard(initialVersion, onAction) {
  const title = h('h2.truncate', { id: `model-${initialVersion.id}` });
  const badge = h('span.badge');
  const activeBadge = h('span.badge.badge-accent', icon('check'), 'in use');
  const timeText = h('span.muted.small');
  const actions = h('div.row.model-actions');
  const statusText = h('p.small');
  const bar = createProgressBar(`Progress of ${initialVersion.name}`);
  const origin = h('dl.origin');
  const figures = h('div.model-figures');
  const element = h(
    'li.model',
    { 'aria-labelledby': title.id },
    h('div.row.model-head', title, badge, activeBadge, h('span.grow'), timeText, actions),
    statusText,
    bar,
    h('div.model-body', origin, figures),
  );
  /** @type {ModelVersion|null} */ let shown = null;
  let actionsKey = '';

  /** @param {ModelVersion} version @param {readonly ModelVersion[]} all */
  function show(version, all) {
    if (version === shown) return;
    const previous = shown;
    shown = version;
    const [text, tone] = stateBadge(version);
    setText(title, version.name);
    setText(badge, text);
    badge.className = `badge ${tone}`;
    activeBadge.hidden = !version.active;
    setText(timeText, moment(version.finished ?? version.created));
    const active = isActive(version);
    statusText.hidden = !active && version.state !== 'failed';
    setText(
      statusText,
      active ? describeProgress(version) : (version.error ?? 'It failed without saying why; the terminal of the server has more.'),
    );
    statusText.classList.toggle('field-error', version.state === 'failed');
    bar.hidden = !active;
    setProgress(bar, progressOf(version));
    if (previous?.lineage !== version.lineage)
      fill(origin, ...describeLineage(version, all).flatMap(([name, value]) => [h('dt', name), h('dd', value)]));
    if (previous?.figures !== version.figures) fill(figures, ...figuresOf(version));
    const key = `${version.state} ${version.active}`;
    if (key !== actionsKey) fill(actions, ...actionsOf(version, onAction));
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
  const isCompared = rows.some(({ before }) => before !== null);
  return h(
    'section',
    { class: `stack ${isCompared ? 'figures-compared' : ''}`, 'aria-label': title },
    h(
      'table.table',
      h('caption', h('strong', title), (note || of) && h('span.muted.small', ` ${[note, of].filter(Boolean).join(' ')}`)),
      h(
        'thead',
        h(
          'tr',
          h('th', { scope: 'col' }, 'Figure'),
          h('th.number', { scope: 'col' }, isCompared ? 'This version' : 'Value'),
          isCompared && h('th.number', { scope: 'col' }, 'Before'),
          isCompared && h('th', { scope: 'col' }, 'Change'),
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
            isCompared && h('td.number', value(row, row.before)),
            isCompared && h('td', { class: `verdict verdict-${row.verdict}` }, describeChange(row)),
          ),
        ),
      ),
    ),
  );
}

/** @param {FigureRow} row @param {number|null} number */
const value = (row, number) => (row.share ? percent(number) : figure(number));

/** @param {FigureRow} row */
function describeChange(row) {
  if (row.verdict === null) return '';
  const [sign, word] = VERDICTS[row.verdict];
  if (row.before === null || row.verdict === 'same') return `${sign} ${word}`;
  const change = row.now - row.before;
  const size = row.share ? `${Math.abs(change * 100).toFixed(1)} points` : figure(Math.abs(change), 2);
  return `${sign} ${word} by ${size}`;
}

/** @param {ModelVersion} version @param {ModelActions} onAction */
function actionsOf(version, onAction) {
  /** @param {string} label @param {() => void} onClick @param {string} [className] */
  const button = (label, onClick, className = '') =>
    h('button', { class: `btn btn-small ${className}`, 'aria-label': `${label} ${version.name}`, onclick: onClick }, label);
  if (isActive(version)) return [button('Cancel', () => onAction.cancel(version))];
  return [
    version.state === 'complete' && !version.active && button('Promote', () => onAction.promote(version), 'btn-primary'),
    (version.state === 'failed' || version.state === 'cancelled') && button('Make again', () => onAction.resume(version)),
    version.id !== 'shipped' && iconButton('delete', `Delete ${version.name}`, () => onAction.remove(version), 'Delete …'),
  ];
}
