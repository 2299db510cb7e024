// @ts-check
/**
 * Tabs following the ARIA practices: arrows move, Home and End jump; only the open panel is updated. On wide screens
 * the panels are shown side by side.
 */

import { h, setProps } from './dom.js';
import { recall, remember } from '../core/preferences.js';
import { createSplitter } from './splitter.js';

/**
 * @param {object} options
 * @param {string} options.label
 * @param {string} options.name    name under which the open tab is remembered
 * @param {string} options.beside   media query for panels side by side
 * @param {{id: string, label: string, view: import('../page-types.js').View}[]} options.tabs   the two tabs
 * @returns {import('../page-types.js').View & {open: (id: string) => void}}
 */
export function createTabs({ label, name, beside, tabs }) {
  let open = tabs.find(({ id }) => id === recall(name))?.id ?? tabs[0].id;
  /** @type {import('../state-types.js').State|null} */
  let last = null;
  const buttons = tabs.map((tab) =>
    h(
      'button.tab',
      {
        role: 'tab',
        id: `tab-${tab.id}`,
        'aria-controls': `panel-${tab.id}`,
        onclick: (/** @type {MouseEvent} */ event) => {
          show(tab.id);
          // a mouse click leaves the keys to the picture; a keyboard user continues from here
          if (event.detail > 0) buttons.forEach((button) => button.blur());
        },
      },
      tab.label,
    ),
  );
  const panels = tabs.map((tab) => h('div.tab-panel', { id: `panel-${tab.id}` }, tab.view.element));
  const list = h('div.tab-list', { role: 'tablist', 'aria-label': label }, ...buttons);
  const element = h('div.tabs');
  const line = createSplitter({
    label: `Width of the ${tabs[1].label.toLowerCase()}`,
    orientation: 'vertical',
    container: element,
    variable: '--second',
    name: `${name}.beside`,
    initial: 50,
    low: 25,
    high: 75,
  });
  element.append(list, panels[0], line, panels[1]);
  const room = matchMedia(beside);
  const ended = new AbortController();
  room.addEventListener('change', arrange, { signal: ended.signal });

  list.addEventListener('keydown', (event) => {
    const at = tabs.findIndex(({ id }) => id === open);
    const next =
      event.key === 'ArrowRight'
        ? at + 1
        : event.key === 'ArrowLeft'
          ? at - 1
          : event.key === 'Home'
            ? 0
            : event.key === 'End'
              ? tabs.length - 1
              : null;
    if (next === null || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    const place = (next + tabs.length) % tabs.length;
    show(tabs[place].id);
    buttons[place].focus();
  });

  /** @param {string} id */
  function show(id) {
    open = id;
    remember(name, id);
    arrange();
  }

  function arrange() {
    const both = room.matches;
    element.classList.toggle('tabs-beside', both);
    list.hidden = both;
    line.hidden = !both;
    tabs.forEach((tab, at) => {
      const on = tab.id === open;
      buttons[at].setAttribute('aria-selected', String(on));
      buttons[at].tabIndex = on ? 0 : -1;
      setProps(panels[at], {
        role: both ? 'region' : 'tabpanel',
        'aria-labelledby': both ? null : `tab-${tab.id}`,
        'aria-label': both ? tab.label : null,
      });
      panels[at].hidden = !on && !both;
      if (!panels[at].hidden && last) tab.view.update(last);
    });
  }
  arrange();

  return {
    element,
    open: show,
    update(state) {
      last = state;
      tabs.forEach(({ view }, at) => panels[at].hidden || view.update(state));
    },
    destroy() {
      ended.abort();
      tabs.forEach(({ view }) => view.destroy());
    },
  };
}
