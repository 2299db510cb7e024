// @ts-check
/** Operations of every screen: palette, help, preferences, theme, other screens. */

import { openDialog, setTheme } from '../store/actions/page.js';
import { operation } from './helpers.js';

/** @typedef {import('../page-types.js').Operation} Operation */

const GROUP = 'Page';
const THEMES = /** @type {const} */ ([
  ['auto', 'Theme: same as the system', 'contrast'],
  ['light', 'Theme: light', 'sun'],
  ['dark', 'Theme: dark', 'moon'],
]);
const SCREENS = /** @type {const} */ ([
  ['library', 'Library', '#/'],
  ['search', 'Search', '#/search'],
  ['files', 'Files', '#/files'],
  ['labels', 'Labels', '#/labels'],
  ['models', 'Models', '#/models'],
  ['team', 'Team', '#/team'],
]);
const everywhere = () => true;
/** Whether the library has people; without them there is no team. @param {import('../state-types.js').State} state */
const withPeople = (state) => state.session?.person != null;

/** @type {Operation[]} */
export const page = [
  operation({
    id: 'palette',
    label: 'Find anything',
    keys: ['Ctrl+K'],
    icon: 'search',
    group: GROUP,
    available: everywhere,
    tooltip: 'Find a command, a label, a track or a setting (Ctrl+K)',
    run: (app) => app.store.dispatch(openDialog, { kind: 'palette' }),
  }),
  operation({
    id: 'help',
    label: 'Help and keys',
    keys: ['F1', '?'],
    icon: 'help',
    group: GROUP,
    available: everywhere,
    run: (app) => app.store.dispatch(openDialog, { kind: 'help' }),
  }),
  operation({
    id: 'preferences',
    label: 'Preferences',
    keys: [],
    icon: 'settings',
    group: GROUP,
    available: everywhere,
    tooltip: 'Preferences: your name, theme',
    run: (app) => app.store.dispatch(openDialog, { kind: 'settings' }),
  }),
  operation({
    id: 'reload',
    label: 'Reload the page',
    keys: [],
    icon: 'refresh',
    group: GROUP,
    available: (state) => state.banners.some(({ id }) => id === 'version'),
    run: () => location.reload(),
  }),
  ...THEMES.map(([theme, label, icon]) =>
    operation({
      id: `theme-${theme}`,
      label,
      keys: [],
      icon,
      group: GROUP,
      available: everywhere,
      run: (app) => app.store.dispatch(setTheme, theme),
    }),
  ),
  ...SCREENS.map(([screen, label, address]) =>
    operation({
      id: `screen-${screen}`,
      label: `Go to: ${label}`,
      keys: [],
      group: GROUP,
      available: screen === 'team' ? withPeople : everywhere,
      run: () => {
        location.hash = address;
      },
    }),
  ),
];
