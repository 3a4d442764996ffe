extends "demo_scene.gd"
## Spheres before, behind and inside a translucent head; one flies through it.

## Seconds of one round.
@export var period := 9.0
## The sphere that moves.
@export var traveller: Node3D
## The volume that it flies through.
@export var head: LumivoxVolume3D
## How dense that is: thin enough to look into.
@export var density := 0.06

## Where on its way the sphere is half inside.
const HALF_INSIDE := 0.07

var _phase := 0.0


func _on_grown(volume: LumivoxVolume) -> void:
	head.density = density
	head.surface_strength = 0.25
	super(volume)


func _hold_still() -> void:
	set_process(false)
	_move_to(HALF_INSIDE)


func _process(delta: float) -> void:
	_phase = fmod(_phase + delta / period, 1.0)
	_move_to(_phase)


func _move_to(phase: float) -> void:
	var angle := phase * TAU
	traveller.position = Vector3(0.30 * sin(angle), 0.055 + 0.03 * sin(angle * 2.0), 0.16 * cos(angle) * cos(angle))
