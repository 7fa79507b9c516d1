// Daylight that comes from over the viewer's left shoulder, so that what is in sight is lit.

import { DirectionalLight, Group, HemisphereLight, type PerspectiveCamera, Vector3 } from "three";

export class Light {
  readonly group = new Group();
  private readonly sun = new DirectionalLight(0xffffff, 1.7);

  constructor() {
    const sky = new HemisphereLight(0xffffff, 0xb9b2a5, 1.4);
    sky.position.set(0, 0, 1);
    this.group.add(sky, this.sun);
  }

  follow(camera: PerspectiveCamera): void {
    const back = camera.getWorldDirection(new Vector3()).negate();
    const left = new Vector3(0, 0, 1).cross(back).normalize().negate();
    this.sun.position.copy(back).addScaledVector(left, 0.7).add(new Vector3(0, 0, 0.7));
  }
}
