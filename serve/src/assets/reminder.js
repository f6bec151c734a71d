// A reminder to press a button, in one of the forms of srs 7.2: a small message that passes, a window that blocks the page until
// the button was used, or vibration and a blinking button. The server says which; each reminder has a number, and shows once.

import { byId, may } from './common.js';

/** Time for which a small message is shown (ms). */
const PASSES = 4000;
const PATTERN = [200, 100, 200];

/** Shows reminders; `press` presses a button of the page by its id. */
export function reminders(press) {
  let shown = null;
  let timer = null;
  const toast = byId('toast');
  const dialog = byId('remind');
  const accept = byId('remind_now');
  let button = null;
  const pass = () => {
    clearTimeout(timer);
    toast.hidden = true;
  };
  accept.addEventListener('click', () => {
    dialog.close();
    if (button) press(button);
  });
  // The window stays until it is answered.
  dialog.addEventListener('cancel', (event) => event.preventDefault());

  /** `of`: the reminder, or nothing; `all`: the buttons of the page. */
  return (of, all) => {
    const target = all.find((b) => b.id === of?.button);
    for (const b of all) byId(b.id).classList.toggle('blinks', of?.kind === 'multimodal' && b === target);
    if (!of || !target) {
      shown = null;
      pass();
      if (dialog.open) dialog.close();
      return;
    }
    button = of.button;
    if (of.kind === 'popup') {
      for (const b of all) if (b !== target) may(byId(b.id), false);
      byId('remind_text').textContent = of.text;
      accept.textContent = target.text;
      may(accept, target.enabled);
    }
    if (of.number === shown) return;
    shown = of.number;
    // A place that is being chosen already is the answer.
    if (of.kind === 'popup' && !dialog.open && byId('point').hidden) dialog.showModal();
    if (of.kind === 'toast') {
      pass();
      toast.textContent = of.text;
      toast.hidden = false;
      timer = setTimeout(pass, PASSES);
    }
    // A browser without vibration, or without a press so far, does nothing.
    if (of.kind === 'multimodal') navigator.vibrate?.(PATTERN);
  };
}
