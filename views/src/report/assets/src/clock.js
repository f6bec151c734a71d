// The one time of the page. Replay, plots, tables and slider all show it and all may move it; the zoom
// of the time axis is shared in the same way.

/** A clock over `start..end` in seconds. Events: `time`, `play`, `zoom`, `speed`. */
export function createClock(start, end) {
  const listeners = { time: [], play: [], zoom: [], speed: [] };
  const emit = (event) => listeners[event].forEach((f) => f());
  const clock = {
    start, end, time: start, playing: false, speed: 1, zoom: null,
    on(event, listener) { listeners[event].push(listener); },
    seek(t) {
      if (!Number.isFinite(t)) return;
      const next = Math.min(end, Math.max(start, t));
      if (next === clock.time) return;
      clock.time = next;
      emit('time');
    },
    play() {
      if (clock.playing || end <= start) return;
      if (clock.time >= end) clock.seek(start);
      clock.playing = true;
      emit('play');
      let last = null;
      requestAnimationFrame(function step(now) {
        if (!clock.playing) return;
        // A tab that slept must not jump: at most half a second passes per picture.
        if (last !== null) clock.seek(clock.time + Math.min(0.5, (now - last) / 1000) * clock.speed);
        last = now;
        if (clock.time >= end) clock.pause();
        else requestAnimationFrame(step);
      });
    },
    pause() {
      if (!clock.playing) return;
      clock.playing = false;
      emit('play');
    },
    toggle() { (clock.playing ? clock.pause : clock.play)(); },
    setSpeed(speed) { clock.speed = speed; emit('speed'); },
    /** `[from, to]` in seconds, or null for the whole run. */
    setZoom(zoom) {
      if (zoom && zoom[1] - zoom[0] < (end - start) * 1e-5) return;
      clock.zoom = zoom && [Math.max(start, zoom[0]), Math.min(end, zoom[1])];
      emit('zoom');
    },
  };
  return clock;
}
