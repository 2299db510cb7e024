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
 * @param {string} options.name   name under which the open tab is remembered
 * @param {string} options.sideBySideQuery   media query for panels side by side
 * @param {{id: string, label: string, view: import('../page-types.js').View}[]} options.tabs   the two tabs
 * @returns {import('../page-types.js').View}
 */
export function createTabs({ label, name, sideBySideQuery, tabs }) {
  let openId = tabs.find(({ id }) => id === recall(name))?.id ?? tabs[0].id;
  /** @type {import('../state-types.js').State|null} */ let lastState = null;
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
  const widthLabel = `Width of the ${tabs[1].label.toLowerCase()}`;
  const divider = createSplitter(element, '--second', 'vertical', {
    label: widthLabel,
    name: `${name}.beside`,
    initial: 50,
    low: 25,
    high: 75,
  });
  element.append(list, panels[0], divider, panels[1]);
  const wideScreen = matchMedia(sideBySideQuery);
  const lifetime = new AbortController();
  wideScreen.addEventListener('change', arrange, { signal: lifetime.signal });

  list.addEventListener('keydown', (event) => {
    const index = tabs.findIndex(({ id }) => id === openId);
    const next = { ArrowRight: index + 1, ArrowLeft: index - 1, Home: 0, End: tabs.length - 1 }[event.key];
    if (next === undefined || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    const nextIndex = (next + tabs.length) % tabs.length;
    show(tabs[nextIndex].id);
    buttons[nextIndex].focus();
  });

  /** @param {string} id */
  function show(id) {
    openId = id;
    remember(name, id);
    arrange();
  }

  function arrange() {
    const isSideBySide = wideScreen.matches;
    element.classList.toggle('tabs-beside', isSideBySide);
    list.hidden = isSideBySide;
    divider.hidden = !isSideBySide;
    tabs.forEach((tab, index) => {
      const isOpen = tab.id === openId;
      buttons[index].setAttribute('aria-selected', String(isOpen));
      buttons[index].tabIndex = isOpen ? 0 : -1;
      setProps(panels[index], {
        role: isSideBySide ? 'region' : 'tabpanel',
        'aria-labelledby': isSideBySide ? null : `tab-${tab.id}`,
        'aria-label': isSideBySide ? tab.label : null,
      });
      panels[index].hidden = !isOpen && !isSideBySide;
      if (!panels[index].hidden && lastState) tab.view.update(lastState);
    });
  }
  arrange();

  return {
    element,
    update(state) {
      lastState = state;
      tabs.forEach(({ view }, index) => panels[index].hidden || view.update(state));
    },
    destroy() {
      lifetime.abort();
      tabs.forEach(({ view }) => view.destroy());
    },
  };
}
