// @ts-check
/** The legend of the picture: switches for its layers. */

import { runName } from '../../model/describe_run.js';
import { LAYER_NAMES, SHORT_NAMES, layerKey, switchLayer } from '../../operations/view.js';
import { openDialog } from '../../store/actions/page.js';
import { LAYERS } from '../../store/initial.js';
import { h, setAttribute, setText } from '../dom.js';
import { icon } from '../icons.js';
import { LAYER_STYLES } from './pen.js';

/** @typedef {import('../../page-types.js').App} App */
/** @typedef {import('../../state-types.js').State} State */

/**
 * Switches of the layers, each with its key in its colour and line style, and the number of boxes in the frame.
 * @param {App} app
 */
export function createLegend(app) {
  /** @type {Map<import('../../state-types.js').LayerName, {button: HTMLElement, count: HTMLElement}>} */
  const rows = new Map();
  const element = h('div.legend', { role: 'group', 'aria-label': 'Layers' });
  LAYERS.forEach((name) => {
    const count = h('span.legend-count.number', '0');
    const swatch = h('kbd.legend-swatch', layerKey(name).replace('Shift+', '⇧'));
    swatch.dataset.layer = name;
    swatch.dataset.dash = LAYER_STYLES[name].dash.length ? 'dashed' : 'solid';
    const button = h(
      'button.legend-item',
      { 'aria-pressed': 'false', title: `${LAYER_NAMES[name]} (${layerKey(name)})`, onclick: () => app.store.dispatch(switchLayer, name) },
      swatch,
      h('span.legend-name.truncate', SHORT_NAMES[name]),
      count,
    );
    rows.set(name, { button, count });
    element.append(button);
    if (name === 'second') {
      element.append(
        h(
          'button.legend-choose',
          {
            title: 'Choose the second run … (Shift+8)',
            'aria-label': 'Choose the second run',
            'data-operation': 'second-run',
            onclick: () => app.store.dispatch(openDialog, { kind: 'second' }),
          },
          icon('down'),
        ),
      );
    }
  });

  /** Show whose boxes a layer has. @param {'truth'|'second'} name @param {string|null} sourceName */
  function setTitle(name, sourceName) {
    const title = `${LAYER_NAMES[name]}${sourceName === null ? '' : `: ${sourceName}`} (${layerKey(name)})`;
    setAttribute(/** @type {{button: HTMLElement}} */ (rows.get(name)).button, 'title', title);
  }

  /** Remove names until the row fits, those of rarely used layers first. No name is truncated. */
  function shortenNames() {
    const all = [...rows.values()].map(({ button }) => button);
    for (const button of all) button.classList.remove('legend-key');
    for (const button of all.reverse()) {
      if (element.scrollWidth <= element.clientWidth) break;
      button.classList.add('legend-key');
    }
  }
  new ResizeObserver(shortenNames).observe(element);
  let shownPressed = '';

  return {
    element,
    /** @param {NonNullable<State['review']>} review @param {Record<string, number>} counts */
    update({ layers: layersOn, truthName, second, video }, counts) {
      const secondRun = second === null ? null : app.store.get().runs[video.id]?.find(({ id }) => id === second);
      setTitle('truth', truthName);
      setTitle('second', second === null ? 'none chosen yet' : secondRun ? runName(secondRun) : null);
      for (const [name, { button, count }] of rows) {
        // the layer of the second run shows nothing until a run is chosen, whatever its switch
        setAttribute(button, 'aria-pressed', String(layersOn[name] && (name !== 'second' || second !== null)));
        // ground truth is loaded only while shown, and without a second run there are no boxes: 0 would be wrong
        const unknown = (name === 'truth' && !layersOn.truth && counts.truth === 0) || (name === 'second' && second === null);
        setText(count, unknown ? '' : String(counts[name]));
      }
      const pressedStates = [...rows.values()].map(({ button }) => button.getAttribute('aria-pressed')).join();
      if (pressedStates === shownPressed) return;
      shownPressed = pressedStates;
      shortenNames();
    },
  };
}
