// Runs before the first paint, so that the page never flashes in the other theme. `theme.js` does the rest.
(() => {
  let chosen = null;
  try {
    chosen = localStorage.getItem('tsr.theme');
  } catch {
    // Storage can be switched off; the system's theme it is.
  }
  const dark = chosen === 'dark' || (chosen !== 'light' && matchMedia('(prefers-color-scheme: dark)').matches);
  document.documentElement.dataset.theme = dark ? 'dark' : 'light';
})();
