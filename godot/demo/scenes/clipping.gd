extends "demo_scene.gd"
## The clip box opens and closes the head, one direction after another, and rests so that the image can converge.

## The volume that is clipped.
@export var head: LumivoxVolume3D
## Seconds of one movement.
@export var move_seconds := 2.5
## Seconds between two movements.
@export var rest_seconds := 3.0

## Corners of the clip box, one after the other.
const POSES: Array[AABB] = [
	AABB(Vector3(0.0, 0.0, 0.0), Vector3(1.0, 1.0, 1.0)),
	AABB(Vector3(0.0, 0.0, 0.0), Vector3(0.5, 1.0, 1.0)),
	AABB(Vector3(0.0, 0.0, 0.0), Vector3(1.0, 1.0, 0.52)),
	AABB(Vector3(0.0, 0.0, 0.0), Vector3(1.0, 0.68, 1.0)),
]

var _tween: Tween


func _on_grown(volume: LumivoxVolume) -> void:
	super(volume)
	_tween = create_tween().set_loops().set_trans(Tween.TRANS_SINE).set_ease(Tween.EASE_IN_OUT)
	for i in range(1, POSES.size() + 1):
		var pose := POSES[i % POSES.size()]
		_tween.tween_interval(rest_seconds)
		_tween.tween_property(head, ^"clip_min", pose.position, move_seconds)
		_tween.parallel().tween_property(head, ^"clip_max", pose.end, move_seconds)


func _hold_still() -> void:
	_tween.kill()
	head.clip_min = POSES[1].position
	head.clip_max = POSES[1].end


func _unhandled_key_input(event: InputEvent) -> void:
	var key := event as InputEventKey
	if key != null and key.pressed and not key.echo and key.keycode == KEY_SPACE and _tween != null:
		if _tween.is_running():
			_tween.pause()
		else:
			_tween.play()
