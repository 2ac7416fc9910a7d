// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { Camera, Color, Geometry, Mesh, Orbit, Program, Renderer, Transform, Vec3 } from 'ogl';
import { el } from './dom';
import { themed } from './palette';

export interface Strand {
  label: string;
  points: number[][];  // x, y, z columns
  color: string;       // of the style sheet, or a colour
  mode: 'line' | 'segments' | 'points';
  alpha?: number;
  size?: number;
}

const kVertex = `
attribute vec3 position;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform float size;
void main() {
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_PointSize = size;
}`;
const kFragment = `
precision mediump float;
uniform vec3 color;
uniform float alpha, round;
void main() {
  if (round > 0.5 && length(gl_PointCoord - 0.5) > 0.5) discard;
  gl_FragColor = vec4(color, alpha);
}`;

/** Lines and points in space; drag to orbit, wheel to zoom, right button to pan. */
export class OrbitView {
  readonly root = el('div', { class: 'orbit', tabindex: 0, role: 'img', 'aria-label': 'Map in space' });
  private renderer: Renderer | null = null;
  private camera: Camera | null = null;
  private orbit: any = null;
  private scene = new Transform();
  private meshes: [Mesh, Strand][] = [];
  private others: Strand[] = [];
  private marker: Mesh | null = null;
  private running = false;
  private radius = 1;
  private middle = new Vec3();

  constructor(private strands: Strand[]) {
    new ResizeObserver(() => this.resize()).observe(this.root);
    document.addEventListener('visibilitychange', () => this.wake());
  }

  /** Builds it when it is first seen: not every page is looked at in space. */
  show() {
    if (!this.renderer && !this.build()) return;
    this.resize();
    this.wake();
  }
  hide() { this.running = false; }

  private build(): boolean {
    try {
      this.renderer = new Renderer({ alpha: true, antialias: true, dpr: Math.min(2, window.devicePixelRatio || 1) });
    } catch {
      this.renderer = null;
    }
    if (!this.renderer || !this.renderer.gl) {
      this.root.append(el('p', { class: 'hint' }, 'This browser shows no WebGL.'));
      this.renderer = null;
      return false;
    }
    const gl = this.renderer.gl;
    this.root.append(gl.canvas as HTMLCanvasElement);
    this.root.append(el('div', { class: 'legend open' }, ...this.strands.map(s => el('div', {},
        el('i', { class: 'line', style: `color: ${s.color.startsWith('#') ? s.color : `var(--${s.color})`}` }), s.label))));
    this.measure();
    this.camera = new Camera(gl, { fov: 40, near: this.radius / 200, far: this.radius * 20 });
    const at = this.middle;
    this.camera.up = new Vec3(0, 0, 1) as any;
    this.camera.position.set(at.x - 0.9 * this.radius, at.y - 1.7 * this.radius, at.z + 1.3 * this.radius);
    this.orbit = new (Orbit as any)(this.camera, { target: at.clone(), element: this.root, ease: 1, inertia: 0.6,
      minDistance: this.radius / 100, maxDistance: this.radius * 8 });
    for (const strand of [...this.strands, ...this.others]) this.meshes.push([this.mesh(strand), strand]);
    for (const type of ['mousedown', 'mousemove', 'wheel', 'touchstart', 'touchmove']) {
      this.root.addEventListener(type, () => this.wake(), { passive: true });
    }
    return true;
  }
  private measure() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const { points } of this.strands) {
      for (let d = 0; d < 3; ++d) for (const v of points[d]) {
        low[d] = Math.min(low[d], v);
        high[d] = Math.max(high[d], v);
      }
    }
    if (low[0] > high[0]) return;
    this.middle.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2);
    this.radius = Math.max(1e-3, 0.6 * Math.hypot(...high.map((h, d) => h - low[d])));
  }
  private mesh(strand: Strand): Mesh {
    const gl = this.renderer!.gl, [x, y, z] = strand.points;
    const position = new Float32Array(3 * x.length);
    for (let i = 0; i < x.length; ++i) position.set([x[i], y[i], z[i]], 3 * i);
    const program = new Program(gl, {
      vertex: kVertex,
      fragment: kFragment,
      uniforms: {
        color: { value: this.color(strand) }, alpha: { value: strand.alpha ?? 1 },
        size: { value: (strand.size ?? 6) * this.renderer!.dpr }, round: { value: strand.mode === 'points' ? 1 : 0 },
      },
      transparent: true,
      depthTest: true,
    });
    const mode = strand.mode === 'line' ? gl.LINE_STRIP : strand.mode === 'segments' ? gl.LINES : gl.POINTS;
    const mesh = new Mesh(gl, { geometry: new Geometry(gl, { position: { size: 3, data: position } }), program, mode, frustumCulled: false });
    mesh.setParent(this.scene);
    return mesh;
  }
  private color(strand: Strand) {
    return new Color(strand.color.startsWith('#') ? strand.color : themed(strand.color));
  }

  /** Shows these too, instead of those that were given before. */
  setOthers(strands: Strand[]) {
    this.others = strands;
    if (!this.renderer) return;
    for (const [mesh] of this.meshes.splice(this.strands.length)) mesh.setParent(null);
    for (const strand of strands) this.meshes.push([this.mesh(strand), strand]);
    this.wake();
  }
  /** A mark at a place. */
  mark(x: number, y: number, z: number) {
    if (!this.renderer) return;
    this.marker?.setParent(null);
    this.marker = this.mesh({ label: '', points: [[x], [y], [z]], color: 'select', mode: 'points', size: 12 });
    this.wake();
  }
  restyle() {
    for (const [mesh, strand] of this.meshes) mesh.program.uniforms.color.value = this.color(strand);
    this.wake();
  }
  private resize() {
    if (!this.renderer || !this.root.clientWidth) return;
    this.renderer.setSize(this.root.clientWidth, this.root.clientHeight);
    this.camera!.perspective({ aspect: this.root.clientWidth / Math.max(1, this.root.clientHeight) });
    this.wake();
  }
  /** Draws for a while: nothing moves by itself. */
  private wake() {
    if (!this.renderer || !this.root.isConnected) return;
    const until = performance.now() + 700;
    this.until = until;
    if (this.running) return;
    this.running = true;
    const frame = () => {
      if (!this.running || document.hidden || performance.now() > this.until) { this.running = false; return; }
      this.orbit.update();
      this.renderer!.render({ scene: this.scene, camera: this.camera! });
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }
  private until = 0;
}

/** Changes between the plan and the view in space that lies over it. */
export function spaceSwitch(orbit: OrbitView): HTMLElement {
  orbit.root.hidden = true;
  const button = el('button', { type: 'button', class: 'small', id: 'space', 'aria-pressed': 'false', title: 'plan, or in space', click: () => {
    const on = orbit.root.hidden;
    orbit.root.hidden = !on;
    button.textContent = on ? 'Plan' : '3-D';
    button.setAttribute('aria-pressed', String(on));
    if (on) orbit.show(); else orbit.hide();
  } }, '3-D');
  return button;
}
